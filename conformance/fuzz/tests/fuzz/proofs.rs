//! A confirmed violation is a proof: its log shows it each time, by itself, on a device that has just been switched on.

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, Machine, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Faults, Firmware};
use canvass_fuzzer::campaign::{Found, Plan, Replay, campaign, run};
use canvass_fuzzer::reproducer::{self, Check};
use canvass_fuzzer::stand::simulated;
use canvass_fuzzer::time_limit::TimeLimit;
use canvass_fuzzer::{Knowledge, Property, Symptom, Target};
use canvass_traces::{Frame, Timestamp};
use std::collections::BTreeSet;

const NODE: NodeId = NodeId::MIN;

fn model() -> &'static Model {
    Model::by_id("reference-301").unwrap()
}

fn plan(target: Target) -> Plan {
    Plan {
        targets: target.into(),
        seed: 5,
        allow: BTreeSet::new(),
        shrink_budget: 200,
        time: TimeLimit::default(),
        stop_at_first: false,
        regressions: Vec::new(),
        only_regressions: false,
        corpus: Vec::new(),
    }
}

/// A bus with a device that has just started.
fn started(device: Box<dyn Machine>) -> SimulatedBus {
    let mut bus = SimulatedBus::new(250_000);
    bus.attach(device);
    while bus.receive(Timestamp(2_000_000_000)).unwrap().is_some_and(|record| record.frame.cob_id() != Some(0x701)) {}
    bus
}

/// Whether a player of the log sees nothing wrong.
fn passes(found: &Found, device: Box<dyn Machine>) -> Option<bool> {
    let check = Check::of(found);
    let played = reproducer::play(&mut started(device), &reproducer::log(found), check.patience(found)).unwrap();
    check.holds(played.since(found.prelude.len()), played.last)
}

fn device(firmware: impl Into<Firmware>) -> Box<dyn Machine> {
    Box::new(Device::new(model(), Some(NODE), firmware.into(), 3))
}

/// Each log shows its violation without the reference models, on a device of the simulated bus and on a device that is
/// reset, and shows nothing on a device without the fault.
#[test]
fn logs_show_what_was_confirmed() {
    for fault in [
        Fault::SdoToggleUnchecked,
        Fault::SdoAbortAnswered,
        Fault::SdoUnknownCommandSilent,
        Fault::SdoBusyAfterAbandonedDownload,
        Fault::NmtStopWhenOperationalIgnored,
        Fault::HeartbeatPeriodDoubled,
    ] {
        let (mut stand, mut knowledge) = simulated(model(), NODE, fault, 250_000, 0);
        let new = run(&mut stand, knowledge.clone(), &plan(Target::All), &mut |state| state.sequences < 1_500).unwrap();
        knowledge = Knowledge::new(NODE, Some(model().description()), Some(model().sheet()));
        let mut bus = started(device(fault));
        let live = campaign(&mut bus, knowledge, &plan(Target::All), &mut |state| state.sequences < 500).unwrap();
        let found: Vec<&Found> = new.violations.iter().chain(&live.violations).filter(|one| one.confirmed).collect();
        assert!(!found.is_empty(), "{fault}");
        for found in found {
            assert_eq!(passes(found, device(fault)), Some(false), "{fault}:\n{}", reproducer::log(found));
            assert_eq!(passes(found, device(Faults::NONE)), Some(true), "{fault}:\n{}", reproducer::log(found));
            assert!(found.repetitions.len() >= 3 && found.shows_by_times(), "{fault}: {found:#?}");
            assert_eq!(found.repetitions[0].replay, Replay::Answers);
        }
    }
}

/// A device whose server aborts with a wrong code once any value was uploaded in segments. Resets do not clear this.
struct Stale {
    device: Device,
    is_stale: bool,
}

impl Machine for Stale {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        self.is_stale |= frame.cob_id() == Some(0x601) && matches!(frame.data(), [0x60, ..]);
        self.device.handle(now, frame);
    }
    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        let frame = self.device.poll_transmit(now)?;
        let is_abort = frame.cob_id() == Some(0x581) && frame.data().starts_with(&[0x80]);
        if !(self.is_stale && is_abort) {
            return Some(frame);
        }
        // The code of a toggle bit that does not alternate.
        let mut data = frame.bytes();
        data[4..8].copy_from_slice(&[0, 0, 3, 5]);
        Frame::new(frame.id(), &data[..8])
    }
    fn poll_timeout(&self) -> Option<Timestamp> {
        self.device.poll_timeout()
    }
    fn handle_timeout(&mut self, now: Timestamp) {
        self.device.handle_timeout(now);
    }
}

/// The fuzzer has uploaded values in segments before the first sequence, and no reset undoes their effect. The logs begin
/// with such an upload.
#[test]
fn what_a_reset_does_not_clear_is_in_the_log() {
    let stale = || Box::new(Stale { device: Device::new(model(), Some(NODE), Faults::NONE, 0), is_stale: false });
    let knowledge = Knowledge::new(NODE, Some(model().description()), Some(model().sheet()));
    let mut bus = started(stale());
    let outcome = campaign(&mut bus, knowledge, &plan(Target::Sdo), &mut |state| state.sequences < 300).unwrap();
    let confirmed: Vec<&Found> = outcome.violations.iter().filter(|found| found.confirmed).collect();
    assert!(!confirmed.is_empty());
    for found in confirmed {
        assert_eq!(passes(found, stale()), Some(false), "{}", reproducer::log(found));
    }
}

/// A server that does not answer the initiation of a block download.
struct Blockless(Device);

impl Machine for Blockless {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        if !(frame.cob_id() == Some(0x601) && matches!(frame.data(), [0xC2 | 0xC4 | 0xC6 | 0xC0, ..])) {
            self.0.handle(now, frame);
        }
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

#[test]
fn a_block_download_without_an_answer_is_one_frame() {
    let knowledge = Knowledge::new(NODE, Some(model().description()), Some(model().sheet()));
    let mut bus = started(Box::new(Blockless(Device::new(model(), Some(NODE), Faults::NONE, 0))));
    let outcome = campaign(&mut bus, knowledge, &plan(Target::Sdo), &mut |state| state.sequences < 300).unwrap();
    let is_it = |found: &&Found| found.violation.rule == "initiate block download";
    let found = outcome.violations.iter().find(is_it).unwrap_or_else(|| panic!("{:#?}", outcome.violations));
    assert!(found.confirmed && found.sequence.stimuli.len() == 1, "{}", reproducer::log(found));
    assert_eq!(
        (found.violation.property, found.violation.symptom),
        (Property::LegalSdo, Symptom::Missing(Some(0x581)))
    );
}

/// Two wrong codes in one situation are two defects.
#[test]
fn findings_of_one_rule_differ_by_the_wrong_code() {
    let faults = Faults::from(Fault::SdoToggleWrongCode).with(Fault::SdoToggleUnchecked);
    let (mut stand, knowledge) = simulated(model(), NODE, faults, 250_000, 0);
    let outcome = run(&mut stand, knowledge, &plan(Target::Sdo), &mut |state| state.sequences < 1_000).unwrap();
    let ids: BTreeSet<String> = outcome.violations.iter().map(|found| found.violation.defect().to_string()).collect();
    assert_eq!(ids.len(), outcome.violations.len(), "{ids:?}");
    assert!(outcome.violations.iter().any(|found| found.times > 1), "{ids:?}");
}
