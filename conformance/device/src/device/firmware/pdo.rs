use super::hooks;
use crate::{Fault, Firmware};
use canvass_traces::Duration;

hooks! {
    stops_rpdo_deadline unless RpdoDeadlineOutlivesStop,
    restarts_rpdo_deadline unless RpdoDeadlineNotRestarted,
    forgets_held_rpdo unless RpdoHeldOverStop,
    heeds_cyclic_timer unless CyclicTimerIdle,
    repeats_inhibited_pdo with TpdoRepeatsAfterInhibit,
    drops_inhibited_pdo with TpdoLostWhenInhibited,
    protects_first_pdo_only with PdoRulesFirstOnly,
    reports_right_rpdo with RightRpdoReported,
    checks_pdo_id_while_valid unless CobIdChangeWhileValid,
    validates_empty_pdo with EmptyPdoValidated,
    checks_mapping_while_valid unless MappingChangeWhileValid,
    checks_rtr_bit unless RtrBitClearable,
    maps_empty_entry with EmptyEntryMapped,
    maps_later_empty_entry with LaterEmptyEntryMapped,
    checks_inhibit_time_while_valid unless InhibitTimeChangeWhileValid,
    checks_mapping_count unless MappingCountUnchecked,
    checks_mapped_length unless MappingLengthUnchecked,
    checks_mapping_sum unless MappingTooLongAccepted,
    maps_missing_object with MissingObjectMapped,
    checks_start_value_while_valid unless SyncStartValueChangeWhileValid,
    maps_unmappable_object with UnmappableObjectMapped,
    maps_dummy_into_tpdo with DummyMappedIntoTpdo,
    checks_transmission_type unless ReservedTransmissionTypeAccepted,
    takes_rtr_type_without_rtr with RtrTypeWithoutRtrAccepted,
    takes_synchronous_rpdo unless SynchronousRpdoRefused,
    takes_remote_frame_for_rpdo with RemoteFrameTakenAsRpdo,
    takes_long_rpdo unless LongRpdoIgnored,
    heeds_rpdo_deadline unless RpdoDeadlineIgnored,
    calls_long_rpdo_late with LongRpdoCalledLate,
    checks_rpdo_length unless RpdoLengthUnchecked,
    reports_short_rpdo unless ShortRpdoUnreported,
    holds_synchronous_rpdo unless SynchronousRpdoActsAtOnce,
    receives_invalid_rpdo with RpdoReceivedWhenInvalid,
    heeds_inhibit_time unless InhibitTimeIgnored,
    samples_rtr_type_at_sync unless RtrTypeSampledAtOnce,
    resets_sync_count unless SyncCountNotReset,
    heeds_sync_cycle unless SyncCycleIgnored,
    overlooks_late_sync_counter with LateSyncCounterOverlooked,
    serves_first_object_only with RpdoFirstObjectOnly,
    refuses_pdo_times with PdoTimesRefused,
    maps_beyond_count with TpdoBeyondCount,
    keeps_tpdo_id_over_reset with TpdoIdOutlivesReset,
    awaits_each_start with SyncStartAgain,
    waits_for_counter_zero with SyncWithoutStartValueIgnored,
    sends_synchronous_pdo_at_start with SynchronousTpdoAtStart,
    heeds_sync_start_value unless SyncStartValueIgnored,
    sends_acyclic_without_event with AcyclicTpdoWithoutEvent,
    misses_first_timed_pdo with FirstPositionMissing,
    sends_pdo_at_start unless TpdoNotSentAtStart,
    checks_rtr_permission unless RemoteFrameAnsweredWhenNotAllowed,
    remembers_sync_over_start with SyncRememberedOverStart,
    delays_synchronous_pdo with SyncTpdoLate,
    sends_last_value with TpdoPositionLate,
    answers_pdo_requests unless TpdoRemoteUnanswered,
}

impl Firmware {
    /// The inhibit time, by sub-index 3 in multiples of 100 us.
    pub(in crate::device) fn inhibit_time(&self, raw: u64) -> Duration {
        Duration::from_micros(raw * if self.has(Fault::InhibitTimeInMilliseconds) { 1_000 } else { 100 })
    }

    /// The time of the event timer, by sub-index 5.
    pub(in crate::device) fn event_timer(&self, millis: u64) -> Duration {
        let late = self.has(Fault::EventTimerOffByOne) && millis > 0;
        let factor = if self.has(Fault::EventTimerDoubled) { 2 } else { 1 };
        Duration::from_millis(millis * factor + u64::from(late))
    }
}
