//! Detects a device, or an adapter in front of it, that answers nonsense: the run ends before it has waited for every
//! case.

use crate::bench::Bench;
use crate::trial::CaseReport;
use crate::verdict::{End, Kind, Reason, Verdict};
use canvass_traces::Timestamp;

/// Number of consecutive cases without a pass and without a completed SDO transfer that ends the run. A device with
/// faults, even many, answers some requests correctly.
const MANY: u32 = 40;

/// Number of such cases that ends the run if they took [`SPAN_NANOS`].
const SOME: u32 = 10;
const SPAN_NANOS: u64 = 60_000_000_000;

/// The verdicts of the latest cases.
#[derive(Default)]
pub(super) struct Nonsense {
    cases: u32,
    /// The begin of the first of these cases.
    since: Option<Timestamp>,
    /// Number of transfers that the device had served at that time.
    served: u64,
}

impl Nonsense {
    /// Adds a case that began at this time. Returns whether the run must end with it; the verdict then says so.
    pub fn judge(&mut self, bench: &Bench<'_>, began: Timestamp, report: &mut CaseReport) -> bool {
        if bench.knowledge.served() != self.served {
            *self = Self { served: bench.knowledge.served(), ..Self::default() };
        }
        match report.verdict.kind() {
            Kind::NotApplicable => return false,
            Kind::Fail | Kind::Inconclusive | Kind::Error if bench.is_live() && !bench.knowledge.has_gone() => {}
            _ => {
                *self = Self { served: bench.knowledge.served(), ..Self::default() };
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
            "the device does not follow the protocol: it passed none of {} consecutive cases, in {took}",
            self.cases
        );
        let duty = "the device, and the adapter before it, follow the protocol";
        let reason = Reason::new(duty, "answers in the form and the time that CiA 301 defines", actual);
        // The frames are in the evidence; there is no single violation to name.
        report.verdict = Verdict::new(Vec::new(), Some(End::Error(reason)));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::Nonsense;
    use crate::bench::{Bench, Evidence, Options, Target};
    use crate::catalogue;
    use crate::runner::{CaseReport, Plan, RunEvent, run};
    use crate::verdict::{Kind, Reason, Verdict};
    use canvass_analyzer::NodeId;
    use canvass_bus::{Bus, BusError};
    use canvass_traces::{ChannelId, Direction, Duration, Frame, Record, Timestamp, parse_frame};
    use std::collections::VecDeque;
    use std::sync::atomic::AtomicBool;

    /// A live bus that answers every request to node 63 with rubbish, and a reset with a boot-up message.
    #[derive(Default)]
    struct Babbler {
        now: Timestamp,
        coming: VecDeque<Record>,
        /// Whether the bus sends nothing at all.
        silent: bool,
        /// Whether the bus is simulated.
        simulated: bool,
    }

    impl Bus for Babbler {
        fn now(&self) -> Timestamp {
            self.now
        }

        fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
            self.coming.push_back(Record::new(self.now, ChannelId(0), *frame).with_direction(Direction::Tx));
            let answer = match (frame.cob_id(), frame.data()) {
                _ if self.silent => return Ok(()),
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
            !self.simulated
        }
    }

    /// Number of cases with this verdict and duration after which the run must end; `None` if more than a hundred.
    fn until(kind: Kind, each: Duration, repeat: u32, gone: bool) -> Option<u32> {
        until_on(Babbler { silent: gone, ..Babbler::default() }, kind, each, repeat, gone)
    }

    fn until_on(mut bus: Babbler, kind: Kind, each: Duration, repeat: u32, gone: bool) -> Option<u32> {
        let cancel = AtomicBool::new(false);
        let target = Target::unknown(NodeId::new(63).unwrap());
        let options = Options { repeat, ..Options::default() };
        let mut annotate = |_: &Record| String::new();
        let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        assert!(!gone || bench.has_left("test/before", |_| {}));
        let mut nonsense = Nonsense::default();
        (1..=100).find(|_| {
            let began = bench.now();
            bench.uncancelled(|bench| bench.listen(each)).unwrap();
            let mut report = ended(kind);
            let ends = nonsense.judge(&bench, began, &mut report);
            assert_eq!(report.verdict.kind(), if ends { Kind::Error } else { kind });
            ends
        })
    }

    fn ended(kind: Kind) -> CaseReport {
        let reason = Reason::default();
        let verdict = match kind {
            Kind::Pass => Verdict::pass(),
            Kind::Inconclusive => Verdict::inconclusive(reason),
            Kind::NotApplicable => Verdict::not_applicable(reason),
            _ => Verdict::error(reason),
        };
        CaseReport {
            case: catalogue::cases()[0],
            verdict,
            evidence: Evidence::default(),
            notes: Vec::new(),
            foreign: Vec::new(),
            measurements: Vec::new(),
            uses: Vec::new(),
            outcomes: vec![kind],
            quarantine: None,
            duration: Duration::ZERO,
        }
    }

    /// A run ends after forty quick cases, or after ten slow ones that took a minute together. A run that repeats its
    /// cases ends after this minute times the number of repetitions.
    #[test]
    fn a_run_ends_after_many_cases_or_some_slow_ones() {
        let ms = Duration::from_millis;
        assert_eq!(until(Kind::Inconclusive, ms(100), 1, false), Some(40));
        assert_eq!(until(Kind::Inconclusive, ms(6_000), 1, false), Some(10));
        assert_eq!(until(Kind::Error, ms(5_000), 1, false), Some(12), "60 s");
        assert_eq!(until(Kind::Inconclusive, ms(6_000), 2, false), Some(20));
        assert_eq!(until(Kind::Inconclusive, ms(6_000), 0, false), Some(10), "0 is once");
        let simulated = Babbler { simulated: true, ..Babbler::default() };
        assert_eq!(until_on(simulated, Kind::Inconclusive, ms(6_000), 1, false), None, "its time costs nothing");
        assert_eq!(until(Kind::NotApplicable, ms(6_000), 1, false), None);
        assert_eq!(until(Kind::Pass, ms(6_000), 1, false), None);
        assert_eq!(until(Kind::Inconclusive, ms(6_000), 1, true), None, "one that is gone is waited for otherwise");
    }

    /// A single case that passes, or a transfer that is served, restarts the count.
    #[test]
    fn a_sign_of_sense_begins_the_count_anew() {
        let (mut bus, cancel) = (Babbler::default(), AtomicBool::new(false));
        let (target, options) = (Target::unknown(NodeId::new(63).unwrap()), Options::default());
        let mut annotate = |_: &Record| String::new();
        let bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        let mut nonsense = Nonsense::default();
        let mut judge = |kind| nonsense.judge(&bench, bench.now(), &mut ended(kind));
        assert!((0..39).all(|_| !judge(Kind::Inconclusive)) && !judge(Kind::NotApplicable) && !judge(Kind::Pass));
        assert!((0..39).all(|_| !judge(Kind::Inconclusive)) && judge(Kind::Inconclusive));
        nonsense = Nonsense { cases: 39, since: Some(Timestamp::ZERO), served: 7 };
        assert!(!nonsense.judge(&bench, bench.now(), &mut ended(Kind::Error)), "others were served since");
        assert_eq!((nonsense.cases, nonsense.served), (1, 0));
    }

    /// The verdicts with their numbers, the notices, and the duration of the run.
    fn tested(options: &Options) -> (Vec<(Kind, usize)>, Vec<String>, Duration) {
        let (mut bus, cancel) = (Babbler::default(), AtomicBool::new(false));
        let target = Target::unknown(NodeId::new(63).unwrap());
        let mut annotate = |_: &Record| String::new();
        let mut bench = Bench::new(&mut bus, &target, options, &mut annotate, &cancel);
        let cases = catalogue::cases();
        let plan = Plan { cases: &cases, bus: "can0", bit_rate: None, seed: 0, shuffle: None };
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
        assert!(notices.iter().any(|notice| notice.contains("its time limit was reached")), "{notices:?}");
        assert!(took < Duration::from_secs(60), "{took}");
    }
}
