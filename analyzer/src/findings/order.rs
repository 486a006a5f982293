//! Sorts records by their times.
//!
//! Kernels with several processors, and adapters with several controllers, reorder frames that arrive at nearly the
//! same time. Without sorting, an answer seems to belong to an earlier request.

use canvass_traces::{Duration, Place, Record, Timestamp};

/// Holds records back for a short time, and returns them sorted by time. Memory is bounded and reused, as every frame
/// of a capture passes through here.
#[derive(Debug, Default)]
pub struct InOrder {
    /// A ring whose length is a power of two.
    ring: Vec<Record>,
    /// Index of the first waiting record, and number of waiting records.
    first: usize,
    waiting: usize,
    newest: Timestamp,
    disorder: Disorder,
}

/// Statistics of records out of order.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Disorder {
    /// Number of records older than the one before them.
    pub count: u64,
    /// The largest time by which a record was older.
    pub largest: Duration,
    /// Time and place of the first record out of order.
    pub first: Option<(Timestamp, Place)>,
}

impl InOrder {
    /// A record that is older than the one before it by more than this time is a step of the clock.
    pub const WINDOW: Duration = Duration::from_millis(20);
    /// Maximum number of waiting records.
    const MOST: usize = 8_192;
    /// Initial size of the ring.
    const LEAST: usize = 64;

    /// Takes the record that was read, and leaves an unused one in its place: nothing is copied.
    #[inline]
    pub fn push(&mut self, record: &mut Record) {
        if self.waiting == self.ring.len() {
            self.grow(record);
        }
        let (time, place) = (record.timestamp, record.place);
        let at = self.place(self.waiting);
        if let Some(slot) = self.ring.get_mut(at) {
            std::mem::swap(slot, record);
            self.waiting += 1;
        }
        debug_assert!(self.ring.len().is_power_of_two() && self.waiting <= self.ring.len());
        if time >= self.newest {
            self.newest = time;
        } else {
            self.sort_in(time, place);
        }
    }

    /// Index of the n-th waiting record.
    #[inline]
    const fn place(&self, n: usize) -> usize {
        (self.first + n) & self.ring.len().wrapping_sub(1)
    }

    /// Doubles the size of the ring.
    #[cold]
    fn grow(&mut self, record: &Record) {
        self.ring.rotate_left(self.first);
        self.first = 0;
        let length = (self.ring.len() * 2).max(Self::LEAST);
        self.ring.resize(length, record.clone());
    }

    /// Moves the last record, which is older than the one before it, to its place.
    #[cold]
    fn sort_in(&mut self, time: Timestamp, place: Place) {
        let late = self.newest.since(time);
        if late > Self::WINDOW {
            // Waiting records precede a step of the clock.
            self.newest = time;
            return;
        }
        self.disorder.count += 1;
        self.disorder.largest = self.disorder.largest.max(late);
        self.disorder.first.get_or_insert((time, place));
        for n in (1..self.waiting).rev() {
            let (before, own) = (self.place(n - 1), self.place(n));
            let ahead = self.ring.get(before).map(|waiting| waiting.timestamp).unwrap_or_default();
            if ahead <= time || ahead.since(time) > Self::WINDOW {
                break;
            }
            self.ring.swap(before, own);
        }
    }

    /// The next record, once no older record can come any more.
    #[inline]
    pub fn pop(&mut self) -> Option<&Record> {
        if self.waiting == 0 {
            return None;
        }
        let first = self.ring.get(self.first)?.timestamp;
        // After a step back of the clock the waiting records are newer than the newest record.
        let is_due = self.newest.since(first) >= Self::WINDOW || first > self.newest || self.waiting > Self::MOST;
        if is_due { self.flush() } else { None }
    }

    /// The next record, even if an older one may still come.
    #[inline]
    pub fn flush(&mut self) -> Option<&Record> {
        if self.waiting == 0 {
            return None;
        }
        let at = self.first;
        (self.first, self.waiting) = (self.place(1), self.waiting - 1);
        self.ring.get(at)
    }

    /// The statistics so far.
    pub const fn disorder(&self) -> Disorder {
        self.disorder
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{CanId, ChannelId, Frame};

    fn through(millis: &[u64]) -> (Vec<u64>, Disorder) {
        let mut order = InOrder::default();
        let mut out = Vec::new();
        let ms = |record: &Record| record.timestamp.nanos() / 1_000_000;
        for &at in millis {
            let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
            order.push(&mut Record::new(Timestamp(at * 1_000_000), ChannelId(0), frame));
            while let Some(record) = order.pop() {
                out.push(ms(record));
            }
        }
        while let Some(record) = order.flush() {
            out.push(ms(record));
        }
        (out, order.disorder())
    }

    #[test]
    fn what_is_a_little_late_comes_in_its_place() {
        let (out, disorder) = through(&[100, 105, 103, 104, 120, 101, 200, 190]);
        assert_eq!(out, [100, 101, 103, 104, 105, 120, 190, 200]);
        assert_eq!((disorder.count, disorder.largest), (4, Duration::from_millis(19)));
        assert_eq!(disorder.first.map(|first| first.0), Some(Timestamp(103_000_000)));
    }

    /// More records than the ring has room for at first, in any order.
    #[test]
    fn many_that_come_at_once() {
        let mut times: Vec<u64> = (0..1_000).map(|n| 1_000 + n / 100).collect();
        for at in (0..990).step_by(7) {
            times.swap(at, at + 9);
        }
        let (out, _) = through(&times);
        assert!(out.is_sorted() && out.len() == 1_000);
    }

    #[test]
    fn a_step_of_the_clock_stays_one() {
        let (out, disorder) = through(&[100, 105, 50, 52, 51, 60, 300]);
        assert_eq!((out, disorder.count), (vec![100, 105, 50, 51, 52, 60, 300], 1));
    }

    #[test]
    fn records_without_times_are_not_kept_for_ever() {
        let mut order = InOrder::default();
        let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
        for _ in 0..20_000 {
            order.push(&mut Record::new(Timestamp(0), ChannelId(0), frame));
            order.pop();
        }
        assert!(order.waiting <= InOrder::MOST + 1 && order.ring.len() <= 4 * InOrder::MOST);
    }
}
