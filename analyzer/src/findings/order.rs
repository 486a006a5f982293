//! Puts records in the order of their times.
//!
//! Kernels with several processors, and adapters with several controllers, hand over frames that have come at nearly the
//! same time in another order. Who looks at them one after the other takes an answer for one to an earlier request.

use canvass_traces::{Duration, Place, Record, Timestamp};
use std::collections::VecDeque;

/// Holds records back for a short time, and gives them out in the order of their times. Memory is bounded.
#[derive(Debug, Default)]
pub struct InOrder {
    waiting: VecDeque<Record>,
    newest: Timestamp,
    disorder: Disorder,
}

/// How far records were out of order.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Disorder {
    /// How many were older than the one before them.
    pub count: u64,
    /// By how much at most.
    pub largest: Duration,
    /// The first of them.
    pub first: Option<(Timestamp, Place)>,
}

impl InOrder {
    /// What comes by more than this too late is a step of the clock.
    pub const WINDOW: Duration = Duration::from_millis(20);
    /// So many records are held back at most.
    const MOST: usize = 8_192;

    /// Takes the next record as it was read.
    #[inline]
    pub fn push(&mut self, record: Record) {
        if record.timestamp >= self.newest {
            self.newest = record.timestamp;
            self.waiting.push_back(record);
        } else {
            self.insert(record);
        }
    }

    /// A record that is older than the one before it.
    #[cold]
    fn insert(&mut self, record: Record) {
        let late = self.newest.since(record.timestamp);
        if late > Self::WINDOW {
            // What is waiting comes before a step of the clock.
            self.newest = record.timestamp;
            self.waiting.push_back(record);
            return;
        }
        self.disorder.count += 1;
        self.disorder.largest = self.disorder.largest.max(late);
        self.disorder.first.get_or_insert((record.timestamp, record.place));
        let younger = self.waiting.iter().rev().take_while(|waiting| {
            waiting.timestamp > record.timestamp && waiting.timestamp.since(record.timestamp) <= Self::WINDOW
        });
        let at = self.waiting.len() - younger.count();
        self.waiting.insert(at, record);
    }

    /// The next record whose turn it is: none that is older can come any more.
    #[inline]
    pub fn pop(&mut self) -> Option<Record> {
        let first = self.waiting.front()?;
        // After a step back of the clock the newest is older.
        let is_due = self.newest.since(first.timestamp) >= Self::WINDOW
            || first.timestamp.since(self.newest) > Duration::ZERO
            || self.waiting.len() > Self::MOST;
        if is_due { self.waiting.pop_front() } else { None }
    }

    /// The next record, whatever may still come.
    pub fn flush(&mut self) -> Option<Record> {
        self.waiting.pop_front()
    }

    /// How far records were out of order so far.
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
        let ms = |record: Record| record.timestamp.nanos() / 1_000_000;
        for &at in millis {
            let frame = Frame::full(CanId::standard_masked(1), [0; 8]);
            order.push(Record::new(Timestamp(at * 1_000_000), ChannelId(0), frame));
            out.extend(std::iter::from_fn(|| order.pop()).map(ms));
        }
        out.extend(std::iter::from_fn(|| order.flush()).map(ms));
        (out, order.disorder())
    }

    #[test]
    fn what_is_a_little_late_comes_in_its_place() {
        let (out, disorder) = through(&[100, 105, 103, 104, 120, 101, 200, 190]);
        assert_eq!(out, [100, 101, 103, 104, 105, 120, 190, 200]);
        assert_eq!((disorder.count, disorder.largest), (4, Duration::from_millis(19)));
        assert_eq!(disorder.first.map(|first| first.0), Some(Timestamp(103_000_000)));
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
            order.push(Record::new(Timestamp(0), ChannelId(0), frame));
            order.pop();
        }
        assert!(order.waiting.len() <= InOrder::MOST);
    }
}
