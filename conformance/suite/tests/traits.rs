//! The whole suite in one run on devices with a trait that makes them hard to put back or to keep alive. The verdicts
//! are right, and the dictionary is the same before and after: the test compares it by SDO, independently of the suite.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_analyzer::dictionary::Access;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::client::sdo::Transfer;
use canvass_bus::client::{Exchange, Outcome};
use canvass_bus::{Bus, Machine, SimulatedBus};
use canvass_device::models::Model;
use canvass_device::{Device, Fault, Faults, Firmware, Liberties, Liberty};
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::catalogue::{Selector, select};
use canvass_suite::comparison::Comparison;
use canvass_suite::runner::{Plan, RunEvent, Summary, run};
use canvass_suite::touch::Touch;
use canvass_suite::verdict::Kind;
use canvass_traces::{Duration, Frame, Record, Timestamp};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::AtomicBool;

const MODEL: &str = "reference-301";

type Dictionary = BTreeMap<Multiplexer, Vec<u8>>;

/// The results of a run, and the dictionaries before and after it.
struct Outcomes {
    verdicts: BTreeMap<&'static str, (Kind, String)>,
    summary: Summary,
    comparison: Comparison,
    before: Dictionary,
    after: Dictionary,
    /// The dictionary after the supply was switched off and on.
    cold: Dictionary,
}

/// The objects that can be written or never change, read by SDO: the test compares them independently of canvass.
fn dictionary(bus: &mut SimulatedBus, node: NodeId, firmware: Firmware) -> Dictionary {
    let description = Model::by_id(MODEL).unwrap().description_with(firmware);
    let mut observe = |_: &Record| {};
    let mut exchange = Exchange { bus, observe: &mut observe, ends: Timestamp::MAX };
    let mut values = Dictionary::new();
    for (multiplexer, entry) in description.dictionary.entries() {
        // 1013h and 2020h are clocks; 1003h holds past errors; 1010h and 1011h hold no values.
        let moves = matches!(multiplexer.index.0, 0x1003 | 0x1010 | 0x1011 | 0x1013 | 0x2020);
        if entry.access.is_readable() && entry.access != Access::Ro && !moves {
            let transfer = Transfer::upload(multiplexer);
            if let Outcome::Uploaded(value) = exchange.transfer(node, transfer, Duration::from_secs(2)).unwrap() {
                values.insert(multiplexer, value);
            }
        }
    }
    values
}

fn tested(firmware: impl Into<Firmware>, selectors: &[&str], allow: &[Touch]) -> Outcomes {
    let (firmware, model) = (firmware.into(), Model::by_id(MODEL).unwrap());
    let device = Device::new(model, model.default_node(), firmware, 0);
    tested_as(Box::new(device), firmware, selectors, allow)
}

fn tested_as(machine: Box<dyn Machine>, firmware: Firmware, selectors: &[&str], allow: &[Touch]) -> Outcomes {
    let model = Model::by_id(MODEL).unwrap();
    let node = model.default_node().unwrap();
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    bus.attach(machine);
    bus.receive(Timestamp::ZERO + Duration::from_secs(6)).unwrap();
    let target = Target::with_firmware(model, node, firmware);
    let before = dictionary(&mut bus, node, firmware);
    let options = Options { allow: allow.iter().copied().collect(), ..Options::default() };
    let selectors: Vec<Selector> = selectors.iter().map(|text| text.parse().unwrap()).collect();
    let cases = select(&selectors).unwrap();
    let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
    let (mut verdicts, mut comparison) = (BTreeMap::new(), None);
    let plan = Plan { cases: &cases, bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    let summary = run(&mut bench, &plan, &mut |event| match event {
        RunEvent::CaseFinished(report) => {
            let breaches = report.verdict.breaches().iter().map(|ruled| ruled.breach.found_text());
            let end = report.verdict.end().map(|end| end.reason().actual.clone());
            let told: Vec<String> = breaches.chain(end).collect();
            verdicts.insert(report.case.id, (report.verdict.kind(), told.join("; ")));
        }
        RunEvent::DictionaryCompared(found) => comparison = Some((*found).clone()),
        _ => {}
    })
    .unwrap();
    let after = dictionary(&mut bus, node, firmware);
    bus.power_cycle(0);
    let booted = bus.now() + Duration::from_secs(6);
    while bus.receive(booted).unwrap().is_some() {}
    let cold = dictionary(&mut bus, node, firmware);
    Outcomes { verdicts, summary, comparison: comparison.unwrap(), before, after, cold }
}

impl Outcomes {
    fn ending(&self, kinds: &[Kind]) -> BTreeSet<&'static str> {
        let ending = self.verdicts.iter().filter(|(_, (kind, _))| kinds.contains(kind));
        ending.map(|(id, _)| *id).collect()
    }

    fn count(&self, kind: Kind) -> usize {
        self.ending(&[kind]).len()
    }

    /// Requires that the dictionary equals the one before the run, now and after the next power-on.
    fn is_as_it_was(&self) {
        let differing = |now: &Dictionary| -> Vec<String> {
            let all: BTreeSet<_> = self.before.keys().chain(now.keys()).collect();
            let wrong = all.into_iter().filter(|at| self.before.get(at) != now.get(at));
            wrong.map(|at| format!("{at} was {:02X?}, is {:02X?}", self.before.get(at), now.get(at))).collect()
        };
        assert!(self.before.len() > 100, "{} objects", self.before.len());
        assert_eq!((differing(&self.after), differing(&self.cold)), (Vec::new(), Vec::new()));
        assert!(self.summary.is_as_found && self.comparison.is_as_found(), "{:?}", self.comparison);
        assert!(self.comparison.commands.is_empty());
    }

    /// Requires that no case failed, and none was inconclusive.
    fn spared(&self) {
        let bad = [Kind::Fail, Kind::Error, Kind::Inconclusive];
        let wrong: Vec<_> = self.verdicts.iter().filter(|(_, (kind, _))| bad.contains(kind)).collect();
        assert!(wrong.is_empty(), "{wrong:#?}");
        self.is_as_it_was();
    }
}

const ALL: &[Touch] = &[Touch::Nvm, Touch::NodeId, Touch::BitRate, Touch::FactoryDefaults, Touch::OtherNodes];

/// Cases that distinguish devices with the trait from others, and enough other cases that change values.
const SOME: &[&str] = &["301/pdo", "301/tpdo", "301/rpdo", "301/emcy", "301/heartbeat", "301/sync", "301/restore"];

#[test]
fn keeps_ram_over_reset() {
    for fault in [Fault::NmtResetNodeKeepsParameters, Fault::NmtResetCommunicationKeepsParameters] {
        let outcomes = tested(fault, &["301", "305", "306"], ALL);
        let failed = outcomes.ending(&[Kind::Fail]);
        // Only cases on resets and on restored values fail.
        let objects = ["301/emcy/moved", "301/heartbeat-consumer/reset", "301/sdo/second-server/reset"];
        let about = [&["301/nmt", "301/store", "301/restore", "305/store"][..], &objects].concat();
        let other: Vec<_> = failed.iter().filter(|id| !about.iter().any(|about| id.starts_with(about))).collect();
        assert!(!failed.is_empty() && other.is_empty(), "{fault}: {failed:?}");
        assert_eq!(outcomes.ending(&[Kind::Error, Kind::Inconclusive]), BTreeSet::new(), "{fault}");
        outcomes.is_as_it_was();
    }
}

#[test]
fn keeps_variables_of_the_manufacturer_over_reset() {
    tested(Liberty::VariablesKept, &["301"], ALL).spared();
}

#[test]
fn refuses_while_valid() {
    let liberties: Liberties = [Liberty::PdoParametersLocked, Liberty::CobIdRewriteRefused].into_iter().collect();
    tested(liberties, &["301"], ALL).spared();
}

#[test]
fn pdos_off() {
    let plain = tested(Firmware::PLAIN, &["301"], ALL);
    let off = tested(Liberty::PdosInvalid, &["301"], ALL);
    plain.spared();
    off.spared();
    // Four cases need PDOs that are valid as delivered; one has no second kind of error without an RPDO.
    let mut missing = plain.ending(&[Kind::NotApplicable]);
    missing.extend(["301/error-history/all", "301/pdo/cob-id/every-valid", "301/pdo/mapping/every-valid"]);
    missing.extend(["301/sync/object", "301/tpdo/synchronous-as-delivered"]);
    assert_eq!(off.ending(&[Kind::NotApplicable]), missing);
    // The device has no objects from 2000h on, and its PDOs map nothing: the error register serves.
    let empty = tested(Liberty::NoApplicationObjects, &["301"], ALL);
    empty.spared();
    for id in ["event-timer", "event-timer-mean", "inhibit-time", "inhibit-unit", "length", "remote", "sync-cycle"] {
        assert_eq!(empty.verdicts[&*format!("301/tpdo/{id}")].0, Kind::Pass, "{id}");
    }
}

#[test]
fn hangs_in_a_case() {
    let outcomes = tested(Fault::HeartbeatConsumerHangs, &["301", "305", "306"], ALL);
    died(&outcomes, "301/heartbeat-consumer/no-node");
}

#[test]
fn dies_after_a_reset() {
    let outcomes = tested(Fault::ResetWhenStoppedHangs, &["301", "305", "306"], ALL);
    // The named case is the first that leaves the device stopped, and resets it to find out whether it is present.
    died(&outcomes, "301/error-behaviour/only-operational");
}

/// Requires that the case in which the device dies fails, that later cases are inconclusive and name that case, that
/// cases without need of a device are judged, and that after the next power-on the device is as before.
fn died(outcomes: &Outcomes, culprit: &str) {
    assert_eq!(outcomes.ending(&[Kind::Fail, Kind::Error]), BTreeSet::from([culprit]));
    let told = &outcomes.verdicts[culprit].1;
    assert!(told.contains("the device stopped answering"), "{told}");
    for (id, (kind, actual)) in &outcomes.verdicts {
        assert!(*kind != Kind::Inconclusive || actual.contains(culprit), "{id}: {actual}");
        if ["306/file", "306/objects"].iter().any(|family| id.starts_with(family)) {
            assert!(matches!(kind, Kind::Pass | Kind::NotApplicable), "{id}: {kind} {actual}");
        }
    }
    assert!(outcomes.count(Kind::Inconclusive) > 50);
    assert!(!outcomes.summary.is_as_found && !outcomes.comparison.is_complete);
    assert_eq!(outcomes.before, outcomes.cold);
}

/// "load" restores the state without node-ID: the device waits for LSS, and gets its node-ID again.
#[test]
fn loses_its_node_id() {
    tested(Liberty::NodeIdRestored, &["301", "305"], ALL).spared();
}

#[test]
fn restarts_in_5_s() {
    tested(Liberty::RestartIn5S, SOME, ALL).spared();
}

#[test]
fn answers_in_900_ms() {
    tested(Liberty::AnswersIn900Ms, SOME, ALL).spared();
}

/// The description contains 1017h, but the device does not have it, or it can't be written: cases about the heartbeat
/// find that, the others are judged.
#[test]
fn one_wrong_object_spoils_no_other_case() {
    const EDS: &str = include_str!("../../device/models/reference-301.eds");
    const SHEET: &str = include_str!("../../device/models/reference-301.toml");
    let (before, rest) = EDS.split_once("[1017]\n").unwrap();
    let (own, after) = rest.split_once("\n\n").unwrap();
    let absent = format!("{before}{after}");
    let constant = format!("{before}[1017]\n{}\n\n{after}", own.replace("AccessType=rw", "AccessType=const"));
    for eds in [absent, constant] {
        let device: &'static Model = Box::leak(Box::new(Model::read(&eds, SHEET).unwrap()));
        let described = Model::by_id(MODEL).unwrap();
        let target = Target::of(described, described.default_node().unwrap());
        let mut bus = SimulatedBus::new(device.default_bit_rate());
        bus.attach(Box::new(Device::new(device, Some(target.node), Firmware::PLAIN, 0)));
        let options = Options { allow: ALL.iter().copied().collect(), ..Options::default() };
        let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
        let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
        let plan = Plan { cases: &select(&[]).unwrap(), bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
        let (mut failed, mut open) = (Vec::new(), Vec::new());
        let summary = run(&mut bench, &plan, &mut |event| {
            if let RunEvent::CaseFinished(report) = event {
                match report.verdict.kind() {
                    Kind::Fail | Kind::Error => failed.push(report.case.id),
                    Kind::Inconclusive => open.push((report.case.id, report.verdict.reason())),
                    _ => {}
                }
            }
        });
        let summary = summary.unwrap();
        assert!(!failed.is_empty() && failed.len() < 8, "{failed:?}");
        assert!(open.len() < 16, "{open:#?}");
        assert!(summary.count(Kind::Pass) > 280, "{summary:?}");
    }
}

/// A lasting error keeps the device out of operational: the cases of its state fail, and cases that need operational
/// are not judged and name the error.
#[test]
fn is_kept_out_of_operational_by_an_error() {
    let outcomes = tested(Fault::NmtStartRefusedInError, &["301"], &[Touch::OtherNodes]);
    outcomes.is_as_it_was();
    let failed = outcomes.ending(&[Kind::Fail, Kind::Error]);
    let judge_states = ["301/nmt/", "301/heartbeat/", "301/guarding/"];
    let others: Vec<_> = failed.iter().filter(|id| !judge_states.iter().any(|family| id.starts_with(family))).collect();
    assert!(failed.contains("301/nmt/pre-operational/start") && others.is_empty(), "{failed:#?}");
    for case in ["301/tpdo/event-timer", "301/sync/moved", "301/rpdo/event-driven", "301/nmt/operational/stop"] {
        let (kind, told) = &outcomes.verdicts[case];
        assert!(*kind == Kind::Inconclusive && told.contains("EMCY 5000h"), "{case}: {kind}: {told}");
    }
    assert!(outcomes.count(Kind::Pass) > 200, "{:?}", outcomes.summary);
    // A case on operational that has not seen this state gives no verdict on it.
    let (kind, told) = &outcomes.verdicts["301/state/operational/sdo"];
    assert!(*kind == Kind::Inconclusive && told.contains("EMCY 5000h"), "{kind}: {told}");
    // An unrelated fault is still found.
    let faults = Faults::from(Fault::NmtStartRefusedInError).with(Fault::SdoUnknownCommandSilent);
    let outcomes = tested(faults, &["301/sdo", "301/tpdo"], &[]);
    assert!(outcomes.ending(&[Kind::Fail]).contains("301/sdo/command/unknown"), "{:?}", outcomes.summary);
}

/// Obeys the first start commands, and no further ones, even after a reset.
struct Tires {
    device: Device,
    starts: u32,
}

impl Machine for Tires {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        if frame.cob_id() == Some(0) && frame.data().first() == Some(&1) {
            self.starts += 1;
            if self.starts > 8 {
                return;
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

/// A device that was operational but no longer can be fails once: later cases name the case after which it could not.
#[test]
fn is_no_longer_operational() {
    let model = Model::by_id(MODEL).unwrap();
    let device = Device::new(model, model.default_node(), Firmware::PLAIN, 0);
    let outcomes = tested_as(Box::new(Tires { device, starts: 0 }), Firmware::PLAIN, &["301/tpdo"], &[]);
    let failed = outcomes.ending(&[Kind::Fail]);
    assert_eq!(failed.len(), 1, "{:#?}", outcomes.verdicts);
    let since = format!("since {}", failed.first().unwrap());
    let later = outcomes.ending(&[Kind::Inconclusive]);
    assert!(
        later.len() > 5 && later.iter().any(|id| outcomes.verdicts[id].1.contains(&since)),
        "{:#?}",
        outcomes.verdicts
    );
}

/// Cases that judge the description alone are judged even if no device is on the bus.
#[test]
fn a_description_needs_no_device() {
    let model = Model::by_id(MODEL).unwrap();
    let target = Target::of(model, model.default_node().unwrap());
    let mut bus = SimulatedBus::new(model.default_bit_rate());
    let selectors: Vec<Selector> = ["306/file", "306/objects"].map(|text| text.parse().unwrap()).to_vec();
    let cases = select(&selectors).unwrap();
    let (options, cancel, mut sent) = (Options::default(), AtomicBool::new(false), 0);
    let mut annotate = |_: &Record| {
        sent += 1;
        String::new()
    };
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &cancel);
    let plan = Plan { cases: &cases, bus: "sim:test", bit_rate: None, seed: 0, shuffle: None };
    let summary = run(&mut bench, &plan, &mut |_| {}).unwrap();
    assert!(cases.len() > 10 && summary.count(Kind::Pass) == cases.len() && summary.is_as_found, "{summary:?}");
    assert_eq!(sent, 0);
}
