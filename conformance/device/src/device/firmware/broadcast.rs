use super::hooks;
use crate::{Fault, Firmware};
use canvass_traces::Duration;

hooks! {
    hangs_of_plain_sync with SyncHangsWithoutCounter,
    heeds_own_sync unless SyncOwnUnheeded,
    stamps_at_each_write with StampSetByOthers,
    ignores_sync_consumer_bit with SyncConsumerBitIgnored,
    follows_time unless TimeIgnored,
    produces_time unless TimeNotProduced,
    keeps_time unless ClockStands,
    sets_reserved_time_bits with TimeReservedBitsSet,
    resets_sync_counter unless SyncCounterNotReset,
    reports_right_sync with RightSyncReported,
    checks_sync_length unless SyncLengthUnchecked,
    keeps_sync_id with SyncKeepsCanId,
    heeds_sync_window unless SyncWindowIgnored,
    counts_moved_sync with SyncMovedCounts,
}

impl Firmware {
    /// The time between SYNC messages, by 1006h.
    pub(in crate::device) fn sync_period(&self, micros: u64) -> Duration {
        Duration::from_micros(micros).times(if self.has(Fault::SyncPeriodDoubled) { 2 } else { 1 })
    }

    /// The counter of the first SYNC.
    pub(in crate::device) const fn first_sync_counter(&self) -> u8 {
        if self.has(Fault::SyncCounterFromZero) { 0 } else { 1 }
    }
}
