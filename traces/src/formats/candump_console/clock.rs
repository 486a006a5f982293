//! The times of candump's console.

use super::{Stamp, Start, start, without_colours};
use crate::formats::candump_log::EPOCH_FROM;
use crate::lines::head_lines;
use crate::{TimeBase, Timestamp};

/// The origin of the times.
#[derive(Default)]
pub(super) struct Clock {
    base: Option<TimeBase>,
    now: u64,
    /// The small time in the line before.
    last: u64,
    differences: bool,
    /// Number of small times seen.
    seen: usize,
}

impl Clock {
    /// Number of small times without a step back, after which a step back is a step of the clock.
    const ENOUGH: usize = 20;

    /// Guesses the origin from the buffered lines, before the first one is read.
    pub(super) fn guess(head: &[u8]) -> Self {
        let small = |line: &[u8]| match start(&without_colours(line)) {
            Ok((_, Start { stamp: Some(Stamp::Seconds(nanos)), .. })) if nanos < EPOCH_FROM => Some(nanos),
            _ => None,
        };
        let times: Vec<u64> =
            head_lines(head).filter(|(_, complete)| *complete).take(1000).filter_map(|(line, _)| small(line)).collect();
        let down = times.windows(2).filter(|pair| pair[1] < pair[0]).count();
        Self { differences: down > 0 && down * 10 >= times.len(), seen: times.len(), ..Self::default() }
    }

    pub(super) fn base(&self) -> TimeBase {
        self.base.unwrap_or(TimeBase::None)
    }

    pub(super) fn time(&mut self, stamp: Option<Stamp>) -> Timestamp {
        let (base, time) = match stamp {
            None => (TimeBase::None, self.now),
            Some(Stamp::Date(nanos)) => (TimeBase::Local, nanos),
            Some(Stamp::Seconds(nanos)) if nanos >= EPOCH_FROM => (TimeBase::Utc, nanos),
            Some(Stamp::Seconds(nanos)) => (TimeBase::Start, self.small(nanos)),
        };
        self.base.get_or_insert(base);
        self.now = time;
        Timestamp(time)
    }

    fn small(&mut self, nanos: u64) -> u64 {
        self.differences |= nanos < self.last && self.seen < Self::ENOUGH;
        self.seen = self.seen.saturating_add(1);
        self.last = nanos;
        if self.differences { self.now.saturating_add(nanos) } else { nanos }
    }
}
