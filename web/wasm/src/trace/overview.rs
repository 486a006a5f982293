//! The number of frames over time by kind, which the page draws above the list.

use super::rows::is_bad;
use canvass_analyzer::Service;
use canvass_analyzer::network::Decoded;
use canvass_traces::Timestamp;
use serde_json::{Value, json};

/// Kinds of frames that have a colour of their own.
const KINDS: [&str; 5] = ["other", "pdo", "sdo", "management", "bad"];

/// Numbers of frames in equal parts of the time.
#[derive(Default)]
pub struct Overview {
    start: Option<Timestamp>,
    last: Timestamp,
    /// The binary logarithm of a part's length in nanoseconds.
    power: u32,
    parts: Vec<[u32; KINDS.len()]>,
}

impl Overview {
    /// Maximum number of parts: when it is reached, each two neighbouring parts become one.
    const MOST: usize = 1024;

    /// Counts the next frame. A frame with an earlier time than the first frame counts to the first part.
    #[inline]
    pub fn take(&mut self, time: Timestamp, decoded: &Decoded) {
        let start = *self.start.get_or_insert(time);
        self.last = self.last.max(time);
        let since = time.nanos().saturating_sub(start.nanos());
        while since >> self.power >= Self::MOST as u64 {
            self.halve();
        }
        let at = (since >> self.power) as usize;
        if self.parts.len() <= at {
            self.parts.resize(at + 1, Default::default());
        }
        if let Some(count) = self.parts.get_mut(at).and_then(|part| part.get_mut(kind(decoded))) {
            *count = count.saturating_add(1);
        }
    }

    #[cold]
    fn halve(&mut self) {
        let sum = |pair: &[[u32; KINDS.len()]]| {
            let mut sum = [0_u32; KINDS.len()];
            let counts = pair.iter().flat_map(|part| part.iter().enumerate());
            counts.for_each(|(kind, count)| {
                if let Some(all) = sum.get_mut(kind) {
                    *all = all.saturating_add(*count);
                }
            });
            sum
        };
        self.parts = self.parts.chunks(2).map(sum).collect();
        self.power += 1;
    }

    /// All counts, with times in seconds.
    pub fn told(&self) -> Value {
        let start = self.start.unwrap_or_default().nanos();
        let span = self.last.nanos().saturating_sub(start);
        let part = 2_f64.powi(self.power.cast_signed());
        json!({ "kinds": KINDS, "span": span as f64 / 1e9, "part": part / 1e9, "parts": self.parts })
    }
}

/// The index of the frame's kind in [`KINDS`].
fn kind(decoded: &Decoded) -> usize {
    match decoded.service {
        service if is_bad(service, &decoded.message, decoded.violation) => 4,
        Service::Nmt | Service::BootUp | Service::Lss | Service::Lmt | Service::FlyingMaster => 3,
        Service::Sdo => 2,
        Service::Pdo | Service::Srdo => 1,
        _ => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::network::Network;
    use canvass_traces::parse_frame;
    use proptest::prelude::*;

    fn overview(frames: &[(u64, &str)]) -> Overview {
        let (mut overview, mut network) = (Overview::default(), Network::new());
        for (time, frame) in frames {
            let record = parse_frame(frame).unwrap();
            overview.take(Timestamp(*time), &network.handle(&record));
        }
        overview
    }

    #[test]
    fn frames_count_to_their_kind_and_time() {
        let frames =
            [(5, "080#"), (5, "185#01"), (6, "605#4000100000000000"), (7, "000#0105"), (7, "085#1111111111111111")];
        let overview = overview(&frames);
        assert_eq!(overview.parts, [[1, 1, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 1]]);
    }

    #[test]
    fn a_long_capture_has_no_more_parts_than_a_short_one() {
        let overview = overview(&[(0, "080#"), (u64::MAX, "080#"), (3, "080#")]);
        assert!(overview.parts.len() <= Overview::MOST);
        assert_eq!(overview.parts[0][0], 2);
    }

    proptest! {
        #[test]
        fn no_frame_is_lost(times in prop::collection::vec(any::<u64>(), 0..200)) {
            let overview = overview(&times.iter().map(|time| (*time, "185#00")).collect::<Vec<_>>());
            let all: u64 = overview.parts.iter().flatten().map(|count| u64::from(*count)).sum();
            prop_assert_eq!(all, times.len() as u64);
        }
    }
}
