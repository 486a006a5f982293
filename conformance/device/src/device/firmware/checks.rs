use super::hooks;
use crate::{Fault, Firmware};

hooks! {
    checks_error_behaviour unless ErrorBehaviourUnchecked,
    checks_history_count unless ErrorHistoryNonZeroAccepted,
    checks_range unless SdoRangeUnchecked,
    checks_work_area_order unless WorkAreaLimitsSwappedAccepted,
    checks_restricted_can_ids unless RestrictedCanIdAccepted,
    takes_frame_bit with CobIdFrameBitTaken,
    checks_cob_id_bits unless CobIdBitsUnchecked,
    restricts_free_can_ids with CanIdsTakenForRestricted,
    keeps_high_bits_only with CanIdLowBitsMovable,
    checks_time_id_while_valid unless TimeIdChangeWhileValid,
    checks_sync_id_while_producing unless SyncIdChangeWhileProducing,
    checks_overflow_while_producing unless SyncOverflowChangeWhileProducing,
    checks_overflow unless SyncOverflowUnchecked,
    checks_emcy_ids_while_valid unless EmcyIdChangeWhileValid,
    checks_sdo_ids_while_valid unless SdoChannelIdChangeWhileValid,
    takes_operating_parameters unless OperatingParametersRefused,
    takes_sync_id unless SyncIdRefused,
    takes_time_id unless TimeIdRefused,
    excludes_consumer_entries with ConsumerEntriesExclude,
    switches_pdos_off unless PdoOffRefused,
    takes_consumer_times unless ConsumerTimeRefused,
    checks_rpdo_values unless RpdoRangeUnchecked,
}
