//! Checks an adapter's time stamps against the arrival times of the frames.
//!
//! A frame arrives some time after its stamp, with a delay that varies with USB, radio and load. The smallest delay is
//! constant. If the delays are different for longer than a connection can be slow, the stamps are wrong.

use super::codec::MINUTE;
use crate::StampTrouble;
use canvass_traces::{Duration, Timestamp};

/// Number of values of a stamp, which counts the milliseconds of a minute: 0 to 59 999.
const VALUES: u16 = 60_000;

/// Usual maximum delay of a frame from the adapter.
const USUAL_DELAY: Duration = Duration::from_millis(100);

/// Maximum duration of unusual delays: if they last longer, the clocks differ.
const LONGEST_DELAY: Duration = Duration::from_secs(1);

/// Upper limit of the drift between quartzes, in parts per million.
const DRIFT_PPM: u64 = 1_000;

/// Number of frames with nearly the same delay after which the smallest delay is known.
const FRAMES: u32 = 10;

/// Minimum interval between two arrivals that can't be in the same millisecond.
const APART: Duration = Duration::from_millis(10);

/// Number of separate arrivals with the same stamp that prove that the clock stands still.
const STILL: u32 = 4;

/// Checks the stamps of one connection.
#[derive(Debug, Default)]
pub(crate) struct StampWatch {
    same: Option<Same>,
    least: Option<Least>,
    /// The time since which delays are longer than usual.
    delayed_since: Option<Timestamp>,
    trouble: Option<StampTrouble>,
}

/// A repeated stamp.
#[derive(Clone, Copy, Debug)]
struct Same {
    milliseconds: u16,
    arrived: Timestamp,
    arrivals: u32,
}

/// The smallest time from a stamp to the arrival of its frame.
#[derive(Clone, Copy, Debug)]
struct Least {
    /// The smallest difference of arrival and stamp, modulo a minute: the clocks have different origins.
    offset: u64,
    /// The arrival time of the frame with this difference.
    at: Timestamp,
    /// Number of frames with nearly the same difference.
    frames: u32,
}

/// The result of checking a stamp.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum StampCheck {
    /// The stamp is right, as far as is known.
    Right,
    /// The frame is late by this time, or the stamp is wrong.
    Doubtful(Duration),
    /// The stamps are wrong and must not be used any more.
    Wrong(StampTrouble),
}

impl StampWatch {
    /// Checks the stamp of a frame against its arrival time.
    pub fn check(&mut self, milliseconds: u16, arrived: Timestamp) -> StampCheck {
        if let Some(trouble) = self.trouble {
            return StampCheck::Wrong(trouble);
        }
        let check = if milliseconds >= VALUES {
            StampCheck::Wrong(StampTrouble::Range)
        } else if self.stands_still(milliseconds, arrived) {
            StampCheck::Wrong(StampTrouble::Still)
        } else {
            self.compare(milliseconds, arrived)
        };
        if let StampCheck::Wrong(trouble) = check {
            self.trouble = Some(trouble);
        }
        check
    }

    fn stands_still(&mut self, milliseconds: u16, arrived: Timestamp) -> bool {
        let first = Same { milliseconds, arrived, arrivals: 1 };
        let same = self.same.get_or_insert(first);
        if same.milliseconds != milliseconds {
            *same = first;
        } else if arrived.since(same.arrived) > APART {
            (same.arrived, same.arrivals) = (arrived, same.arrivals + 1);
        }
        same.arrivals >= STILL
    }

    /// Compares the delay with the smallest one so far.
    fn compare(&mut self, milliseconds: u16, arrived: Timestamp) -> StampCheck {
        let offset = (arrived.0 % MINUTE + MINUTE - u64::from(milliseconds) * 1_000_000) % MINUTE;
        let first = Least { offset, at: arrived, frames: 0 };
        let least = self.least.get_or_insert(first);
        let drift = Duration(arrived.since(least.at).0 / 1_000_000 * DRIFT_PPM);
        let limit = USUAL_DELAY + drift;
        let (later, earlier) = ((offset + MINUTE - least.offset) % MINUTE, (least.offset + MINUTE - offset) % MINUTE);
        if earlier <= later {
            if earlier > limit.0 && least.frames >= FRAMES {
                return StampCheck::Wrong(StampTrouble::Jump);
            }
            // This frame shows that the earlier frames were late.
            *least = Least { frames: if earlier > limit.0 { 0 } else { least.frames + 1 }, ..first };
        } else if later > limit.0 {
            let since = *self.delayed_since.get_or_insert(arrived);
            let lasts = arrived.since(since) > LONGEST_DELAY;
            return if lasts { StampCheck::Wrong(StampTrouble::Jump) } else { StampCheck::Doubtful(Duration(later)) };
        } else {
            least.frames += 1;
        }
        self.delayed_since = None;
        StampCheck::Right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The checks of frames, each given as its stamp and its arrival time in milliseconds.
    fn checked(frames: impl IntoIterator<Item = (u64, u64)>) -> Vec<StampCheck> {
        let mut watch = StampWatch::default();
        let at = |ms: u64| Timestamp(1_700_000_000_000_000_000 + ms * 1_000_000);
        frames.into_iter().map(|(stamp, arrived)| watch.check(stamp as u16, at(arrived))).collect()
    }

    fn trouble(frames: impl IntoIterator<Item = (u64, u64)>) -> Option<(usize, StampTrouble)> {
        checked(frames).into_iter().enumerate().find_map(|(at, check)| match check {
            StampCheck::Wrong(trouble) => Some((at, trouble)),
            _ => None,
        })
    }

    /// Frames arrive every 10 ms for five minutes, across four restarts of the stamps, delayed by up to 90 ms.
    #[test]
    fn stamps_that_are_right_stay_right() {
        let frames = (0..30_000_u64).map(|n| ((n * 10 + 12_345) % 60_000, n * 10 + n * 7919 % 90));
        assert!(checked(frames).iter().all(|check| *check == StampCheck::Right));
        let bursts = (0..1_000_u64).map(|n| (n * 50 / 1_000, n / 200 * 20));
        assert_eq!(trouble(bursts), None, "many frames of a millisecond in one read");
    }

    /// A drift of 500 ppm, and a minute without a frame.
    #[test]
    fn a_clock_that_drifts_is_followed() {
        for drift in [-500_i64, 500] {
            let stamp = |n: u64| (((n * 100) as i64 + (n * 100) as i64 * drift / 1_000_000) % 60_000) as u64;
            assert_eq!(trouble((0..20_000_u64).map(|n| (stamp(n), n * 100))), None, "{drift} ppm");
            assert_eq!(trouble([0, 1, 601, 1_300].map(|n| (stamp(n), n * 100))), None, "{drift} ppm");
        }
    }

    /// A radio link pauses: late frames are doubtful, and no stamp is regarded as wrong.
    #[test]
    fn a_way_that_pauses_is_no_wrong_clock() {
        let frames = (0..500_u64).map(|n| (n * 20, if (100..140).contains(&n) { 140 * 20 } else { n * 20 }));
        let checked = checked(frames);
        assert_eq!(checked[100], StampCheck::Doubtful(Duration::from_millis(800)));
        assert!(checked[140..].iter().all(|check| *check == StampCheck::Right));
        let late_at_first = (0..500_u64).map(|n| (n * 20, if n < 5 { 400 } else { n * 20 + 400 - 390 }));
        assert_eq!(trouble(late_at_first), None);
    }

    #[test]
    fn a_clock_that_stands_still_is_wrong_at_once() {
        assert_eq!(trouble((0..9).map(|n| (7_777, n * 100))), Some((3, StampTrouble::Still)));
        let from = (0..50_u64).map(|n| (n.min(20) * 100, n * 100));
        assert_eq!(trouble(from), Some((23, StampTrouble::Still)));
    }

    /// The clock jumps back, jumps forward, and restarts at the wrong time.
    #[test]
    fn a_clock_that_jumps_is_wrong() {
        let jump = |by: u64| (0..60_u64).map(move |n| ((n * 100 + 5_000 + by * (n / 30)) % 60_000, n * 100));
        assert_eq!(trouble(jump(60_000 - 4_000)), Some((41, StampTrouble::Jump)), "back, told after a second");
        assert_eq!(checked(jump(60_000 - 4_000))[30], StampCheck::Doubtful(Duration::from_secs(4)));
        assert_eq!(trouble(jump(4_000)), Some((30, StampTrouble::Jump)), "forward");
        assert_eq!(
            trouble((0..800_u64).map(|n| (n * 100 % 50_000, n * 100))).map(|(_, what)| what),
            Some(StampTrouble::Jump)
        );
        assert_eq!(trouble((0..800_u64).map(|n| (n * 100 % 65_536, n * 100))), Some((600, StampTrouble::Range)));
    }

    /// If a clock runs at half the speed, its stamps fall behind more and more.
    #[test]
    fn a_clock_of_the_wrong_speed_is_wrong() {
        assert_eq!(trouble((0..100_u64).map(|n| (n * 50, n * 100))).map(|(_, what)| what), Some(StampTrouble::Jump));
    }
}
