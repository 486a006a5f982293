//! Buses that are interrupted at random moments, in virtual time. The device is not blamed for an interruption, and the
//! results are kept when the bus does not come back.

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, BusError, Health, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Faults};
use canvass_fuzzer::campaign::{Outcome, Plan, Progress, campaign};
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Knowledge, Sequence, Stimulus, Target};
use canvass_traces::{CanId, ChannelId, Direction, Duration, Frame, Record, Timestamp};
use std::collections::{BTreeSet, VecDeque};

const NODE: NodeId = NodeId::MIN;

/// The connection to a bus that is interrupted again and again, or from a moment on for good.
struct Interrupted {
    bus: SimulatedBus,
    /// The beginning of the current or next interruption.
    begins: Timestamp,
    ends: Timestamp,
    /// Number of interruptions that are over.
    past: u64,
    /// Frames that were handed over and got lost, although the tester regards them as sent.
    lost: VecDeque<Record>,
    chance: u64,
    /// The moment from which on the bus does not come back.
    gone: Timestamp,
}

impl Interrupted {
    fn new(device: Device, seed: u64) -> Self {
        let mut bus = SimulatedBus::new(250_000);
        bus.attach(Box::new(device));
        let chance = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
        let never = Timestamp::MAX;
        let mut way = Self { bus, begins: never, ends: never, past: 0, lost: VecDeque::new(), chance, gone: never };
        way.plan(Timestamp::ZERO);
        way
    }

    /// A bus that is interrupted only once, and for good.
    fn gone_at(device: Device, gone: Timestamp) -> Self {
        Self { begins: gone, ends: Timestamp::MAX, gone, ..Self::new(device, 0) }
    }

    fn random(&mut self, below: u64) -> u64 {
        self.chance ^= self.chance << 13;
        self.chance ^= self.chance >> 7;
        self.chance ^= self.chance << 17;
        self.chance % below
    }

    /// Plans the next interruption, some time after `after`.
    fn plan(&mut self, after: Timestamp) {
        self.begins = after + Duration::from_millis(100 + self.random(3_000));
        self.ends = self.begins + Duration::from_micros(500 + self.random(2_000_000));
    }

    /// Whether the connection is interrupted at the time `at`. Time must not go back.
    fn is_away(&mut self, at: Timestamp) -> bool {
        while at >= self.ends {
            self.past += 1;
            self.plan(self.ends);
        }
        at >= self.begins
    }
}

impl Bus for Interrupted {
    fn now(&self) -> Timestamp {
        self.bus.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        /// A frame that is handed over just before an interruption does not reach the bus.
        const UNDER_WAY: Duration = Duration::from_micros(400);
        while self.is_away(self.bus.now()) {
            if self.bus.now() >= self.gone {
                return Err(BusError::Interrupted { trouble: "the way is gone".to_owned(), waited: Duration::ZERO });
            }
            let ends = self.ends;
            while self.bus.receive(ends)?.is_some() {}
        }
        let now = self.bus.now();
        if now + UNDER_WAY >= self.begins {
            self.lost.push_back(Record::new(now, ChannelId(0), *frame).with_direction(Direction::Tx));
            return Ok(());
        }
        self.bus.send(frame)
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        if let Some(lost) = self.lost.pop_front() {
            return Ok(Some(lost));
        }
        while let Some(record) = self.bus.receive(deadline)? {
            if !self.is_away(record.timestamp) {
                return Ok(Some(record));
            }
        }
        self.is_away(self.bus.now());
        Ok(None)
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bus.bit_rate()
    }

    fn health(&self) -> Health {
        let since = Some(self.begins).filter(|begins| self.bus.now() >= *begins);
        let interruptions = self.past + u64::from(since.is_some());
        Health { interruptions, interrupted_since: since, ..Health::default() }
    }
}

/// A sequence whose second request for a segment of 2010h:00 repeats the toggle bit.
fn toggle_repeated() -> Sequence {
    let request = |bytes| Stimulus::settle(Frame::full(CanId::standard_masked(0x601), bytes));
    let stimuli = [[0x40, 0x10, 0x20, 0, 0, 0, 0, 0], [0x70, 0, 0, 0, 0, 0, 0, 0]].map(request);
    Sequence { stimuli: stimuli.to_vec(), ..Sequence::default() }
}

fn fuzz(bus: &mut Interrupted, target: Target, go_on: &mut dyn FnMut(Progress<'_>) -> bool) -> Outcome {
    fuzz_after(Vec::new(), bus, target, go_on)
}

/// Fuzzes after the given sequences.
fn fuzz_after(
    regressions: Vec<Sequence>,
    bus: &mut Interrupted,
    target: Target,
    go_on: &mut dyn FnMut(Progress<'_>) -> bool,
) -> Outcome {
    let model = Model::by_id("reference-301").unwrap();
    let knowledge = Knowledge::new(NODE, Some(model.description()), Some(model.sheet()));
    let plan = Plan {
        targets: target.into(),
        seed: 4,
        allow: BTreeSet::new(),
        shrink_budget: 60,
        time: TimeLimit::default(),
        stop_at_first: false,
        regressions,
        only_regressions: false,
        corpus: Vec::new(),
    };
    campaign(bus, knowledge, &plan, go_on).unwrap()
}

fn device(faults: impl Into<Faults>) -> Device {
    Device::new(Model::by_id("reference-301").unwrap(), Some(NODE), faults.into(), 0)
}

#[test]
fn no_device_is_blamed_for_its_bus() {
    let (mut interruptions, mut unjudged) = (0, 0);
    for seed in 0..20 {
        let mut bus = Interrupted::new(device(Faults::default()), seed);
        let outcome = fuzz(&mut bus, Target::All, &mut |progress| progress.sequences < 200);
        assert!(outcome.violations.is_empty(), "seed {seed}: {:#?}", outcome.violations);
        assert_eq!((outcome.ended_by, outcome.dead), (None, false), "seed {seed}");
        interruptions += outcome.interruptions.map_or(0, |interruptions| interruptions.count);
        unjudged += outcome.unjudged;
    }
    assert!(interruptions > 100, "{interruptions}");
    assert!((interruptions / 2..=interruptions).contains(&unjudged), "{unjudged} of {interruptions}");
}

#[test]
fn a_fault_is_found_and_confirmed_between_interruptions() {
    for seed in 0..6 {
        let mut bus = Interrupted::new(device(Fault::SdoToggleUnchecked), seed);
        let outcome = fuzz(&mut bus, Target::Sdo, &mut |progress| progress.sequences < 60);
        let found: Vec<_> = outcome.violations.iter().map(|found| (found.violation.rule, found.confirmed)).collect();
        assert!(found.iter().any(|(rule, confirmed)| rule.contains("toggle") && *confirmed), "seed {seed}: {found:?}");
    }
}

/// Results are kept whenever the bus is lost, also while a violation is repeated or made shorter.
#[test]
fn what_was_found_is_kept() {
    let (mut kept, mut cut_off) = (0, 0);
    for moment in 0..250 {
        let gone = Timestamp::ZERO + Duration::from_millis(400 + moment * 30);
        let mut bus = Interrupted::gone_at(device(Fault::SdoToggleUnchecked), gone);
        let mut told = 0;
        let outcome = fuzz_after(vec![toggle_repeated()], &mut bus, Target::Sdo, &mut |progress| {
            told = progress.violations;
            true
        });
        assert_eq!(outcome.ended_by.as_deref(), Some("the way is gone; the bus was not back within 0 ns"), "{moment}");
        assert!(outcome.violations.len() >= told, "{moment}: {told} of {:#?}", outcome.violations);
        assert!(outcome.violations.iter().all(|found| found.confirmed != found.is_cut_off), "{moment}");
        assert_eq!(outcome.left, None, "{moment}");
        kept += usize::from(told > 0);
        cut_off += outcome.violations.iter().filter(|found| found.is_cut_off).count();
    }
    assert!(kept > 20 && cut_off > 2, "{kept}, {cut_off}");
}
