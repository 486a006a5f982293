//! When a finding occurred, over the whole capture, in bounded memory.

use super::effect::SOON;
use canvass_traces::Timestamp;

/// The occurrences of a finding, in the order of time. If there are many, near ones share a span.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Occurrences {
    spans: Vec<Span>,
}

/// One occurrence, or several that are near each other.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Span {
    begin: Timestamp,
    /// The begin of the last occurrence.
    last: Timestamp,
    end: Timestamp,
    count: u64,
}

impl Span {
    fn merged(self, next: Self) -> Self {
        Self {
            begin: self.begin.min(next.begin),
            last: self.last.max(next.last),
            end: self.end.max(next.end),
            count: self.count + next.count,
        }
    }

    /// Times at which occurrences begin: as many as there are, at most [`Self::POINTS`], evenly from first to last.
    fn points(self) -> impl Iterator<Item = Timestamp> {
        let steps = self.count.clamp(1, Self::POINTS) - 1;
        let length = self.last.since(self.begin).nanos();
        (0..=steps).map(move |n| Timestamp(self.begin.nanos() + length / steps.max(1) * n))
    }

    const POINTS: u64 = 8;
}

impl Occurrences {
    /// Maximum number of spans.
    const SPANS: usize = 32;

    /// Adds an occurrence.
    pub(super) fn add(&mut self, begin: Timestamp, end: Timestamp) {
        let new = Span { begin, last: begin, end, count: 1 };
        if self.spans.len() < Self::SPANS {
            return self.spans.push(new);
        }
        // Occurrences nearer than the time within which effects follow are told apart by no rule.
        if let Some(last) = self.spans.last_mut().filter(|last| begin.since(last.end) <= SOON) {
            *last = last.merged(new);
            return;
        }
        self.join_nearest();
        self.spans.push(new);
    }

    /// Joins the two spans with the shortest time between them.
    fn join_nearest(&mut self) {
        let gaps = self.spans.windows(2).map(|two| two[1].begin.since(two[0].end));
        let Some((at, _)) = gaps.enumerate().min_by_key(|(_, gap)| *gap) else { return };
        let next = self.spans.remove(at + 1);
        self.spans[at] = self.spans[at].merged(next);
    }

    /// Begin and end of each span.
    pub(super) fn spans(&self) -> impl Iterator<Item = (Timestamp, Timestamp)> {
        self.spans.iter().map(|span| (span.begin, span.end))
    }

    /// The number of occurrences that begin at times for which `is_so`, and of all.
    pub(super) fn count(&self, is_so: impl Fn(Timestamp) -> bool) -> (u64, u64) {
        let of_span = |span: &Span| {
            let points = span.points().count() as u64;
            let hits = span.points().filter(|at| is_so(*at)).count() as u64;
            (hits * span.count / points, span.count)
        };
        self.spans.iter().map(of_span).fold((0, 0), |sum, row| (sum.0 + row.0, sum.1 + row.1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn s(seconds: u64) -> Timestamp {
        Timestamp(seconds * 1_000_000_000)
    }

    #[test]
    fn few_occurrences_stay_as_they_are() {
        let mut occurrences = Occurrences::default();
        (0..32).for_each(|n| occurrences.add(s(n), s(n)));
        assert_eq!(occurrences.count(|at| at < s(10)), (10, 32));
        assert_eq!(occurrences.spans().count(), 32);
    }

    #[test]
    fn many_occurrences_keep_their_share() {
        let mut occurrences = Occurrences::default();
        (0..1_000).for_each(|n| occurrences.add(s(10 * n), s(10 * n + 1)));
        let (early, all) = occurrences.count(|at| at < s(1_000));
        assert_eq!(all, 1_000);
        assert!((50..=150).contains(&early), "{early}");
        assert_eq!(occurrences.count(|_| true), (1_000, 1_000));
    }

    proptest! {
        #[test]
        fn nothing_is_lost(steps in proptest::collection::vec(0_u64..100, 1..300)) {
            let mut occurrences = Occurrences::default();
            let mut now = 0;
            for step in &steps {
                now += step;
                occurrences.add(s(now), s(now + 1));
            }
            prop_assert_eq!(occurrences.count(|_| true), (steps.len() as u64, steps.len() as u64));
            prop_assert_eq!(occurrences.count(|_| false).0, 0);
            let spans: Vec<_> = occurrences.spans().collect();
            prop_assert!(spans.len() <= Occurrences::SPANS);
            prop_assert_eq!((spans[0].0, spans[spans.len() - 1].1), (s(steps[0]), s(now + 1)));
        }
    }
}
