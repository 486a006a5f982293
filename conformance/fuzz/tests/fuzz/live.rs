//! Live devices with special traits: devices that are slow, that keep their memory over a reset, or that a reset kills.
//! They run in the time of a simulated bus.

use crate::perishable::Perishable;
use canvass_analyzer::wire::sdo;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::Exchange;
use canvass_bus::client::sdo::{self as sdo_client, Mode, Transfer};
use canvass_bus::{Bus, Machine, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Faults, Firmware, Liberties, Liberty};
use canvass_fuzzer::campaign::{Found, Outcome, Plan, campaign, replay};
use canvass_fuzzer::coverage::SdoReach;
use canvass_fuzzer::stand::{Readiness, TestStand};
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Kept, Knowledge, Live, Property, Start, Target, reproducer};
use canvass_traces::{Frame, Timestamp};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

const NODE: NodeId = NodeId::MIN;

fn model() -> &'static Model {
    Model::by_id("reference-301").unwrap()
}

fn fuzz(device: Box<dyn Machine>, described: &Model, target: Target, sequences: u64) -> Outcome {
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(device);
    let knowledge = Knowledge::new(NODE, Some(described.description()), Some(described.sheet()));
    campaign(&mut bus, knowledge, &plan(target), &mut |progress| progress.sequences < sequences).unwrap()
}

fn plan(target: Target) -> Plan {
    Plan {
        targets: target.into(),
        seed: 4,
        allow: BTreeSet::new(),
        shrink_budget: 60,
        time: TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    }
}

fn with(firmware: impl Into<Firmware>, target: Target, sequences: u64) -> Outcome {
    let firmware = firmware.into();
    let described = model().taking(firmware.liberties);
    fuzz(Box::new(Device::new(model(), Some(NODE), firmware, 0)), &described, target, sequences)
}

fn told(outcome: &Outcome) -> Vec<String> {
    let tell = |found: &Found| {
        let frames = found.sequence.stimuli.len();
        format!("{:?}, confirmed {}, {frames} frames", found.violation, found.confirmed)
    };
    outcome.violations.iter().map(tell).collect()
}

#[test]
fn slow_devices_and_such_with_habits_of_their_own_violate_nothing() {
    for liberty in [
        Liberty::AnswersIn900Ms,
        Liberty::AnswersVary,
        Liberty::RestartIn5S,
        Liberty::VariablesKept,
        Liberty::PdosInvalid,
        Liberty::PdoParametersLocked,
        Liberty::CobIdRewriteRefused,
        Liberty::ToggleIgnored,
        Liberty::LostHeartbeatUnreported,
        Liberty::OwnTraffic,
        Liberty::OwnSdoClient,
        Liberty::NoLssInquiry,
    ] {
        let outcome = with(Liberties::from(liberty), Target::All, 150);
        assert!(outcome.violations.is_empty(), "{liberty}: {:#?}", told(&outcome));
        assert!(outcome.executions > 500 && outcome.unjudged == 0 && !outcome.dead, "{liberty}");
        let left = outcome.left.unwrap();
        let is_slow = matches!(liberty, Liberty::AnswersIn900Ms | Liberty::AnswersVary);
        assert!(left.different.is_empty() && (left.compared == left.settings) != is_slow, "{liberty}: {left:?}");
    }
}

/// CiA 305 does not mention parts of another address between parts of the slave's own address. The case
/// `305/switch-selective/interleaved` only records the behaviour of the slave.
#[test]
fn a_slave_that_goes_on_after_parts_of_another_address_violates_nothing() {
    let outcome = with(Fault::LssSelectiveMismatchIgnored, Target::Lss, 1_000);
    assert!(outcome.violations.is_empty(), "{:#?}", told(&outcome));
}

/// Counts the resets that a device gets.
struct Counted(Device, Arc<AtomicU64>);

impl Machine for Counted {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        if frame.cob_id() == Some(0) && frame.data() == [0x81, NODE.raw()] {
            self.1.fetch_add(1, Ordering::Relaxed);
        }
        self.0.handle(now, frame);
    }
    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        self.0.poll_transmit(now)
    }
    fn poll_timeout(&self) -> Option<Timestamp> {
        self.0.poll_timeout()
    }
    fn handle_timeout(&mut self, now: Timestamp) {
        self.0.handle_timeout(now);
    }
}

/// Runs the SDO target on a device with the faults. Returns the outcome and the number of resets.
fn counted(faults: Faults, sequences: u64) -> (Outcome, u64) {
    let resets = Arc::new(AtomicU64::new(0));
    let device = Counted(Device::new(model(), Some(NODE), faults, 0), Arc::clone(&resets));
    let outcome = fuzz(Box::new(device), model(), Target::Sdo, sequences);
    (outcome, resets.load(Ordering::Relaxed))
}

/// Asserts that nearly all reachable combinations were reached.
fn assert_covered(outcome: &Outcome) {
    let (reached, all) = outcome.coverage.sdo_share(SdoReach { blocks: true, long_values: true });
    assert!(reached * 100 >= all * 95, "{reached} of {all}");
}

/// Most sequences begin in the state in which the previous sequence has ended. The coverage is as high as with a new
/// device for each sequence.
#[test]
fn few_resets_are_needed() {
    let (outcome, resets) = counted(Faults::NONE, 1_500);
    assert!(outcome.violations.is_empty(), "{:#?}", told(&outcome));
    // About one in ten sequences of this target contains a reset of its own.
    assert!(resets * 3 < outcome.sequences, "{resets} resets for {} sequences", outcome.sequences);
    assert_covered(&outcome);
}

/// A violation that was reported before ends no sequence and needs no reset, so that the rest of the sequence is
/// reached.
#[test]
fn a_device_that_breaks_most_sequences_is_covered_too() {
    let faults = [
        Fault::SdoAbortAnswered,
        Fault::SdoAbortMultiplexerZero,
        Fault::SdoToggleWrongCode,
        Fault::SdoUnknownCommandSilent,
        Fault::SdoLengthUnchecked,
        Fault::SdoBusyAfterAbandonedTransfer,
        Fault::SdoBusyAfterAbandonedDownload,
    ];
    let all = faults.into_iter().fold(Faults::NONE, Faults::with);
    let (outcome, resets) = counted(all, 1_500);
    assert!(outcome.violations.len() >= faults.len(), "{:#?}", told(&outcome));
    assert!(outcome.violations.iter().all(|found| found.confirmed), "{:#?}", told(&outcome));
    assert!(resets * 2 < outcome.sequences, "{resets} resets for {} sequences", outcome.sequences);
    assert_covered(&outcome);
}

/// A run resets the device at its end even if its time is over, so that values that were not stored are restored.
#[test]
fn a_run_that_is_cut_short_leaves_the_device_as_it_was_found() {
    struct Last(Device, Arc<AtomicU64>);
    impl Machine for Last {
        fn handle(&mut self, now: Timestamp, frame: &Frame) {
            let is_reset = frame.cob_id() == Some(0) && frame.data() == [0x81, NODE.raw()];
            // The requests that begin an upload or read its segments.
            let is_sdo_read = frame.cob_id() == Some(0x601) && matches!(frame.data(), [0x40 | 0x60 | 0x70, ..]);
            if is_reset || !is_sdo_read {
                self.1.store(u64::from(is_reset), Ordering::Relaxed);
            }
            self.0.handle(now, frame);
        }
        fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
            self.0.poll_transmit(now)
        }
        fn poll_timeout(&self) -> Option<Timestamp> {
            self.0.poll_timeout()
        }
        fn handle_timeout(&mut self, now: Timestamp) {
            self.0.handle_timeout(now);
        }
    }
    let was_reset = Arc::new(AtomicU64::new(0));
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(Last(Device::new(model(), Some(NODE), Faults::NONE, 0), Arc::clone(&was_reset))));
    let knowledge = Knowledge::new(NODE, Some(model().description()), Some(model().sheet()));
    let plan = plan(Target::Pdo);
    let cancelled = Arc::clone(&plan.time.cancelled);
    // The run ends by itself here: no further frame is sent or counted.
    let mut cut_short = |progress: canvass_fuzzer::campaign::Progress<'_>| {
        cancelled.store(progress.sequences >= 20, Ordering::Relaxed);
        true
    };
    let outcome = campaign(&mut bus, knowledge, &plan, &mut cut_short).unwrap();
    assert!(outcome.sequences == 20 && was_reset.load(Ordering::Relaxed) == 1, "{}", outcome.sequences);
}

/// Makes a transfer in the name of the device's user.
fn tell(bus: &mut SimulatedBus, what: (Transfer, sdo::Request)) -> sdo_client::Outcome {
    let mut exchange = Exchange { bus, observe: &mut |_| (), ends: Timestamp::MAX };
    exchange.transfer(NODE, what, canvass_traces::Duration::from_secs(1)).unwrap()
}

/// The user has stored another value in 2030h:0F than the description has. The run must leave the stored value.
#[test]
fn stored_values_of_eight_bytes_are_left_as_they_were() {
    let (number, stored) = (Multiplexer::new(0x2030, 0xF), [8, 7, 6, 5, 4, 3, 2, 1]);
    let mut bus = SimulatedBus::new(250_000);
    // A reset restores nothing. The run writes the stored values back, not the values of the description.
    let keeps = Faults::from(Fault::NmtResetNodeKeepsParameters).with(Fault::NmtResetCommunicationKeepsParameters);
    bus.attach(Box::new(Device::new(model(), Some(NODE), keeps, 0)));
    while bus.receive(Timestamp(1_000_000_000)).unwrap().is_some() {}
    for (at, value) in [(number, &stored[..]), (Multiplexer::new(0x1010, 1), b"save")] {
        let written = tell(&mut bus, Transfer::download(at, value, Mode::Shortest));
        assert_eq!(written, sdo_client::Outcome::Downloaded, "{at}");
    }
    let knowledge = Knowledge::new(NODE, Some(model().description()), Some(model().sheet()));
    let outcome = campaign(&mut bus, knowledge, &plan(Target::Sdo), &mut |progress| progress.sequences < 600).unwrap();
    let left = outcome.left.unwrap();
    assert!(left.compared > 50 && left.different.is_empty(), "{left:?}");
    assert_eq!(tell(&mut bus, Transfer::upload(number)), sdo_client::Outcome::Uploaded(stored.to_vec()));
}

/// A device that keeps the first number that is written to 2030h, and refuses further writes to this object.
struct Stuck {
    device: Device,
    at: Option<Multiplexer>,
}

impl Machine for Stuck {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        if let (Some(0x601), &[command, low, high, sub, value, ..]) = (frame.cob_id(), frame.data()) {
            let at = Multiplexer::from_bytes([low, high, sub]);
            // UNSIGNED8, UNSIGNED16 and UNSIGNED32.
            let is_number = matches!((command, sub), (0x2F, 5) | (0x2B, 6) | (0x23, 7)) && at.index.0 == 0x2030;
            // Initiate download or initiate block download.
            if self.at == Some(at) && matches!(command >> 5, 1 | 6) {
                return;
            }
            if is_number && value != 0 {
                self.at.get_or_insert(at);
            }
        }
        self.device.handle(now, frame);
    }
    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        self.device.poll_transmit(now)
    }
    fn poll_timeout(&self) -> Option<Timestamp> {
        self.device.poll_timeout()
    }
    fn handle_timeout(&mut self, now: Timestamp) {
        self.device.handle_timeout(now);
    }
}

#[test]
fn what_can_not_be_brought_back_is_told_at_the_end() {
    let faults = Faults::from(Fault::NmtResetNodeKeepsParameters).with(Fault::NmtResetCommunicationKeepsParameters);
    let device = Device::new(model(), Some(NODE), faults, 0);
    let outcome = fuzz(Box::new(Stuck { device, at: None }), model(), Target::Sdo, 1_000);
    let left = outcome.left.unwrap().different;
    assert!(matches!(left[..], [Kept { at, value: 1.., power_on: 0 }] if at.index.0 == 0x2030), "{left:?}");
}

/// Resets that restore nothing are reported. Later sequences are judged by the actual values.
#[test]
fn memory_that_is_kept_over_resets_is_written_back() {
    let faults = Faults::from(Fault::NmtResetNodeKeepsParameters).with(Fault::NmtResetCommunicationKeepsParameters);
    let outcome = with(faults, Target::Sdo, 600);
    let restored = |found: &&Found| found.violation.property == Property::Restored;
    assert!(outcome.violations.iter().any(|found| restored(&found)), "{:#?}", told(&outcome));
    assert!(outcome.violations.iter().all(|found| found.state.is_empty()), "all of it could be written back");
    for found in outcome.violations.iter().filter(|found| found.confirmed) {
        // A confirmed violation has to come back from power-on.
        let mut bus = SimulatedBus::new(250_000);
        bus.attach(Box::new(Device::new(model(), Some(NODE), faults, 0)));
        let knowledge = Knowledge::new(NODE, Some(model().description()), Some(model().sheet()));
        let again = replay(&mut Live::new(&mut bus, &knowledge), knowledge.clone(), &found.sequence).unwrap().0;
        let again = again.unwrap_or_else(|| {
            panic!("not from power-on: {:?}\n{}", found.violation, reproducer::candump(&found.sequence))
        });
        assert_eq!((again.property, again.rule), (found.violation.property, found.violation.rule), "{found:?}");
    }
}

/// A device that dies and comes back only after several resets, or never.
struct Mortal {
    machine: Perishable,
    /// Number of SDO frames until the device is dead.
    left: u32,
    /// Number of resets that bring the device back.
    needs: u32,
}

impl Machine for Mortal {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let is_reset = frame.cob_id() == Some(0) && frame.data() == [0x81, NODE.raw()];
        match (self.machine.dead, is_reset) {
            (true, true) => {
                self.needs = self.needs.saturating_sub(1);
                self.machine.dead = self.needs > 0;
            }
            (false, true) if self.left == 0 => self.machine.dead = true,
            (false, false) if frame.cob_id() == Some(0x601) => self.left = self.left.saturating_sub(1),
            _ => {}
        }
        self.machine.handle(now, frame);
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        self.machine.poll_transmit(now)
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        self.machine.poll_timeout()
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        self.machine.handle_timeout(now);
    }
}

fn mortal(needs: u32) -> Outcome {
    let machine = Perishable::new(Device::new(model(), Some(NODE), Faults::NONE, 0));
    // The fuzzer reads many objects before the first sequence.
    fuzz(Box::new(Mortal { machine, left: 600, needs }), model(), Target::Sdo, 300)
}

#[test]
fn a_device_that_a_reset_kills_is_a_violation_with_its_last_frames() {
    let outcome = mortal(u32::MAX);
    assert!(outcome.dead && outcome.sequences < 300, "the run ends");
    let last = outcome.violations.last().unwrap();
    assert_eq!(last.violation.property, Property::Alive, "{:#?}", told(&outcome));
    assert!(!last.evidence.is_empty() && !last.sequence.stimuli.is_empty());
}

#[test]
fn a_device_that_needs_another_reset_is_a_violation_too_and_the_run_goes_on() {
    let outcome = mortal(1);
    assert!(!outcome.dead);
    assert_eq!(outcome.sequences, 300);
    let found = outcome.violations.iter().find(|found| found.violation.property == Property::Alive).unwrap();
    assert!(!found.evidence.is_empty(), "{:#?}", told(&outcome));
}

/// An earlier sequence has made the device operational. Without it, the last sequence shows nothing from power-on.
#[test]
fn a_violation_that_needs_an_earlier_command_has_a_short_reproducer() {
    for seed in 1..=6 {
        let mut bus = SimulatedBus::new(250_000);
        let faults = Faults::from(Fault::NmtStopWhenOperationalIgnored);
        bus.attach(Box::new(Device::new(model(), Some(NODE), faults, 0)));
        let knowledge = Knowledge::new(NODE, Some(model().description()), Some(model().sheet()));
        let plan = Plan { seed, stop_at_first: true, shrink_budget: 100, ..plan(Target::Nmt) };
        let outcome = campaign(&mut bus, knowledge, &plan, &mut |progress| progress.sequences < 300).unwrap();
        let found = &outcome.violations[0];
        // The violation shows in error control, or in an answer that must not come.
        let is_it = matches!(found.violation.property, Property::NmtState | Property::Silent);
        assert!(is_it && found.confirmed, "{seed}: {found:#?}");
        assert!(found.sequence.stimuli.len() <= 8, "{seed}: {found:#?}");
        assert!(outcome.sequences <= 40, "{seed}: {} sequences", outcome.sequences);
    }
}

/// Shortening the many violations of a device takes no more than its share of the time, and all are short at the end.
#[test]
fn violations_are_made_shorter_beside_the_run() {
    let all = [Fault::SdoUnknownCommandSilent, Fault::SdoToggleWrongCode, Fault::SdoLengthUnchecked];
    let outcome = with(all.into_iter().fold(Faults::NONE, Faults::with), Target::Sdo, 1_500);
    assert!(outcome.violations.len() >= 3, "{:#?}", told(&outcome));
    for found in &outcome.violations {
        assert!(found.confirmed && found.sequence.stimuli.len() <= 8, "{:#?}", told(&outcome));
    }
    let (shortening, all) = (outcome.spent_on_violations.total(), outcome.spent.total());
    assert!(shortening.nanos() * 2 < all.nanos(), "{shortening} of {all}");
}

/// A device whose reset takes a while, in which it receives nothing.
struct Deaf {
    device: Device,
    /// The reset in progress, and the time of its end.
    reset: Option<(Timestamp, Frame)>,
}

impl Machine for Deaf {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let is_reset = frame.cob_id() == Some(0) && matches!(frame.data(), [0x81 | 0x82, 0 | 1]);
        match self.reset {
            Some(_) => {}
            None if is_reset => self.reset = Some((now + canvass_traces::Duration::from_millis(60), *frame)),
            None => self.device.handle(now, frame),
        }
    }
    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        if self.reset.is_some() { None } else { self.device.poll_transmit(now) }
    }
    fn poll_timeout(&self) -> Option<Timestamp> {
        self.reset.map_or_else(|| self.device.poll_timeout(), |(at, _)| Some(at))
    }
    fn handle_timeout(&mut self, now: Timestamp) {
        match self.reset.take_if(|(at, _)| *at <= now) {
            Some((_, frame)) => self.device.handle(now, &frame),
            None if self.reset.is_none() => self.device.handle_timeout(now),
            None => {}
        }
    }
}

/// The boot-up message of an earlier reset is not taken for that of the next reset, during which requests are lost.
#[test]
fn a_reset_that_is_under_way_is_waited_for() {
    let device = Device::new(model(), Some(NODE), Fault::SdoToggleWrongCode, 0);
    let outcome = fuzz(Box::new(Deaf { device, reset: None }), model(), Target::All, 400);
    let rules: Vec<_> = outcome.violations.iter().map(|found| found.violation.property).collect();
    assert_eq!(rules, [Property::LegalSdo], "{:#?}", told(&outcome));
    let (starts, time) = outcome.spent.of(canvass_fuzzer::Cause::Start);
    assert!(starts > 3 && time.nanos() / starts < 1_000_000_000, "{starts} starts took {time}");
}

#[test]
fn a_run_whose_time_ends_while_the_device_starts_does_not_call_it_dead() {
    let firmware = Firmware::from(Liberties::from(Liberty::RestartIn5S));
    let described = model().taking(firmware.liberties);
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(Box::new(Device::new(model(), Some(NODE), firmware, 0)));
    let knowledge = Knowledge::new(NODE, Some(described.description()), Some(described.sheet()));
    let over = TimeLimit { cancelled: Arc::new(AtomicBool::new(true)), ..TimeLimit::default() };
    let mut live = Live::new(&mut bus, &knowledge).until(over);
    for _ in 0..3 {
        assert_eq!(live.begin(Start::Configured).unwrap(), Readiness::Ready);
    }
}

/// The fuzzer waits only once if CiA 305 leaves an answer open, or if the state of the SDO server is unknown.
#[test]
fn little_time_goes_into_silence() {
    for target in [Target::All, Target::Sdo] {
        let outcome = with(Faults::NONE, target, 1_000);
        let (_, silence) = outcome.spent.of(canvass_fuzzer::Cause::Silence);
        assert!(silence.nanos() * 20 < outcome.spent.total().nanos(), "{}", outcome.spent);
    }
}

/// A device without boot-up message violates the standard already in the frames before each repetition. The finding is
/// confirmed all the same, by repetitions without these frames.
#[test]
fn a_boot_up_message_that_is_missing_is_confirmed() {
    let outcome = with(Fault::BootUpMissing, Target::All, 60);
    let missing = outcome.violations.iter().find(|found| found.violation.rule == "boot-up after reset");
    let found = missing.unwrap_or_else(|| panic!("{:#?}", told(&outcome)));
    assert!(found.confirmed && found.sequence.stimuli.len() == 1, "{:#?}", told(&outcome));
}
