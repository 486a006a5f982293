//! A device, or an adapter before it, that answers what no device answers: the run ends before it has waited for all of it.

use super::event::CaseReport;
use crate::bench::Bench;
use crate::verdict::{End, Kind, Reason, Verdict};
use canvass_traces::Timestamp;

/// As many cases in a row that could not be passed, however fast, and without one SDO transfer that came to its end: a
/// device with faults, however many they are, answers some of what it is asked.
const MANY: u32 = 40;

/// As many of them if they took that long.
const SOME: u32 = 10;
const SPAN_NANOS: u64 = 60_000_000_000;

/// How the cases have ended lately.
#[derive(Default)]
pub(super) struct Nonsense {
    cases: u32,
    /// Where the first of them began.
    since: Option<Timestamp>,
    /// How many transfers the device had served then.
    served: u64,
}

impl Nonsense {
    /// Takes in a case that began at that time; says whether the run is to end with it, which the verdict tells then.
    pub fn judge(&mut self, bench: &Bench<'_>, began: Timestamp, report: &mut CaseReport) -> bool {
        if bench.served() != self.served {
            *self = Self { served: bench.served(), ..Self::default() };
        }
        match report.verdict.kind() {
            Kind::NotApplicable => return false,
            Kind::Fail | Kind::Inconclusive | Kind::Error if bench.is_live() && !bench.has_gone() => {}
            _ => {
                *self = Self { served: bench.served(), ..Self::default() };
                return false;
            }
        }
        self.cases += 1;
        let took = bench.now().since(*self.since.get_or_insert(began));
        let is_slow = took.nanos() >= SPAN_NANOS * u64::from(bench.options().repeat.max(1));
        if self.cases < if is_slow { SOME } else { MANY } {
            return false;
        }
        let actual = format!(
            "the device does not follow the protocol: none of {} cases in a row could be passed, in {took}",
            self.cases
        );
        let duty = "the device, and the adapter before it, follow the protocol";
        let reason = Reason::new(duty, "answers in the form and the time that CiA 301 gives them", actual);
        // What came is in the evidence; what it breaks can't be said of each frame.
        report.verdict = Verdict::new(Vec::new(), Some(End::Error(reason)));
        true
    }
}

#[cfg(test)]
mod tests {
    use crate::bench::{Bench, Options, Target};
    use crate::catalogue;
    use crate::runner::{Plan, RunEvent, run};
    use crate::verdict::Kind;
    use canvass_analyzer::NodeId;
    use canvass_bus::{Bus, BusError};
    use canvass_traces::{ChannelId, Direction, Duration, Frame, Record, Timestamp, parse_frame};
    use std::collections::VecDeque;
    use std::sync::atomic::AtomicBool;

    /// A live bus on which every request to node 63 is answered with rubbish, and a reset with a boot-up message.
    #[derive(Default)]
    struct Babbler {
        now: Timestamp,
        coming: VecDeque<Record>,
    }

    impl Bus for Babbler {
        fn now(&self) -> Timestamp {
            self.now
        }

        fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
            self.coming.push_back(Record::new(self.now, ChannelId(0), *frame).with_direction(Direction::Tx));
            let answer = match (frame.cob_id(), frame.data()) {
                (Some(0x63F), _) => "5BF#EEEEEEEEEEEEEEEE",
                (Some(0), [0x81 | 0x82, _]) => "73F#00",
                _ => return Ok(()),
            };
            let at = self.now + Duration::from_millis(20);
            self.coming.push_back(Record::new(at, ChannelId(0), parse_frame(answer).unwrap().frame));
            Ok(())
        }

        fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
            let next = self.coming.pop_front_if(|record| record.timestamp <= deadline.max(self.now));
            self.now = next.as_ref().map_or(deadline, |record| record.timestamp).max(self.now);
            Ok(next)
        }

        fn bit_rate(&self) -> Option<u32> {
            None
        }

        fn is_live(&self) -> bool {
            true
        }
    }

    /// What was judged, the notices, and how long the run took.
    fn tested(options: &Options) -> (Vec<(Kind, usize)>, Vec<String>, Duration) {
        let (mut bus, cancel) = (Babbler::default(), AtomicBool::new(false));
        let target = Target::unknown(NodeId::new(63).unwrap());
        let mut annotate = |_: &Record| String::new();
        let mut bench = Bench::new(&mut bus, &target, options, &mut annotate, &cancel);
        let cases = catalogue::cases();
        let plan = Plan { cases: &cases, bus: "can0", bit_rate: None, seed: 0 };
        let (mut ends, mut notices) = (Vec::new(), Vec::new());
        let _ = run(&mut bench, &plan, &mut |event| match event {
            RunEvent::CaseFinished(report) => ends.push((report.verdict.kind(), report.evidence.frames().count())),
            RunEvent::Noticed(text) => notices.push((*text).to_owned()),
            _ => {}
        });
        (ends, notices, bus.now.since(Timestamp::ZERO))
    }

    #[test]
    fn a_device_that_talks_nonsense_ends_the_run_with_an_error_and_its_frames() {
        let (ends, notices, took) = tested(&Options::default());
        let &(last, frames) = ends.last().unwrap();
        assert_eq!((last, frames > 0), (Kind::Error, true), "{ends:?}");
        assert!(ends.len() < catalogue::cases().len() / 2, "{} cases ran", ends.len());
        assert!(notices.iter().any(|notice| notice.contains("does not follow the protocol")), "{notices:?}");
        assert!(took < Duration::from_secs(300), "{took}");
    }

    #[test]
    fn a_run_ends_when_its_time_is_over() {
        let options = Options { limit: Some(Duration::from_secs(8)), ..Options::default() };
        let (_, notices, took) = tested(&options);
        assert!(notices.iter().any(|notice| notice.contains("--for")), "{notices:?}");
        assert!(took < Duration::from_secs(60), "{took}");
    }
}
