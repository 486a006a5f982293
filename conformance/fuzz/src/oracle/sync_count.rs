//! The SYNC count of a synchronous TPDO: the TPDO follows every n-th SYNC, from any start of the count, after some
//! time.

/// The SYNC messages since the PDO was started or configured, and the range of SYNC messages that may cause the next
/// TPDO.
///
/// CiA 301 (7.2.2.2, 7.5.2.37) says that a TPDO of transmission type n follows every n-th SYNC. It does not say with
/// which of the first n SYNC messages the TPDO begins, nor how long after a SYNC it comes if 1007h sets no window. So a
/// TPDO shows its SYNC only within a range, which narrows with each TPDO.
#[derive(Clone, Debug)]
pub(super) struct SyncCount {
    /// Number of SYNC messages since the beginning.
    syncs: u64,
    /// The first and the last SYNC that may cause the next TPDO, by their numbers. `None` before the first TPDO.
    next: Option<(u64, u64)>,
    /// Whether the device has certainly counted the same SYNC messages as the model. A SYNC that the device may have
    /// ignored ends this certainty.
    in_step: bool,
}

impl SyncCount {
    pub const fn new() -> Self {
        Self { syncs: 0, next: None, in_step: true }
    }

    /// Whether the device has certainly counted the same SYNC messages as the model.
    pub(crate) const fn is_in_step(&self) -> bool {
        self.in_step
    }

    /// Records a SYNC, or a TPDO of another cause, that the device may or may not count.
    pub const fn doubt(&mut self) {
        self.in_step = false;
    }

    /// Counts a SYNC. `true`: it is the last SYNC that may cause the TPDO of transmission type `kind`.
    pub fn sync(&mut self, kind: u8) -> bool {
        self.syncs += 1;
        let (_, last) = self.next.unwrap_or((1, kind.into()));
        kind == 1 || self.in_step && self.syncs == last
    }

    /// Number of SYNC messages since the beginning.
    pub const fn syncs(&self) -> u64 {
        self.syncs
    }

    /// Records a TPDO of transmission type `kind`. `false`: no SYNC can be its cause.
    pub fn came(&mut self, kind: u8) -> bool {
        let (first, last) = self.next.unwrap_or((1, kind.into()));
        if first > self.syncs {
            return !self.in_step;
        }
        let kind = u64::from(kind);
        // If a second TPDO could already have been due, this TPDO may stand for both.
        let last = if first + kind <= self.syncs { self.syncs } else { last.min(self.syncs) };
        self.next = Some((first + kind, last + kind));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::SyncCount;

    /// Counts SYNC messages, and the TPDOs sent after the messages with the numbers `sent`. Returns the number of the
    /// first SYNC at which something is wrong.
    fn wrong_at(kind: u8, sent: &[u64], syncs: u64) -> Option<u64> {
        let mut count = SyncCount::new();
        let mut due = None;
        for sync in 1..=syncs {
            // In this test a due TPDO comes before the next SYNC.
            if due.is_some() {
                return due;
            }
            due = count.sync(kind).then_some(sync);
            for _ in sent.iter().filter(|&&at| at == sync) {
                if !count.came(kind) {
                    return Some(sync);
                }
                due = None;
            }
        }
        due
    }

    #[test]
    fn a_count_may_begin_anywhere_and_is_kept_then() {
        assert_eq!(wrong_at(3, &[3, 6, 9], 9), None);
        assert_eq!(wrong_at(3, &[1, 4, 7], 9), None);
        assert_eq!(wrong_at(3, &[2, 5, 8], 9), None);
        assert_eq!(wrong_at(1, &[1, 2, 3], 3), None);
    }

    #[test]
    fn a_wrong_count_shows() {
        assert_eq!(wrong_at(3, &[], 9), Some(3), "never");
        assert_eq!(wrong_at(3, &[1, 2, 3], 9), Some(2), "with every SYNC");
        assert_eq!(wrong_at(3, &[4, 8], 9), Some(3), "every fourth");
        assert_eq!(wrong_at(3, &[2, 4, 6], 9), Some(6), "every second");
        assert_eq!(wrong_at(3, &[3], 9), Some(6), "once");
        assert_eq!(wrong_at(1, &[1, 1], 3), Some(1), "twice after one SYNC");
    }

    #[test]
    fn a_late_tpdo_may_stand_for_two() {
        let mut count = SyncCount::new();
        for due in [false, true, false] {
            assert_eq!(count.sync(2), due);
        }
        assert!(count.came(2), "for the first SYNC, the third or both");
        assert!(!count.sync(2), "the fourth");
        assert!(count.sync(2), "the fifth");
    }

    #[test]
    fn after_a_doubtful_sync_nothing_is_wrong() {
        let mut count = SyncCount::new();
        assert!(!count.sync(2));
        count.doubt();
        assert!(!count.sync(2) && count.came(2) && count.came(2) && count.came(2));
    }
}
