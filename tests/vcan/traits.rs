//! Devices that are hard to restore or to keep alive, on a real socket: `test` and `fuzz` give the same results as on
//! the simulated bus (conformance/suite/tests/traits.rs), and the device has its old values afterwards.

use crate::interface::Interface;
use crate::running::{Running, brief, eventually, run, simulate, text};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// The property that a device breaks if no reset revives it.
const ALIVE: &str = "PROP-16";

const ALLOWED: &str = "nvm,node-id,other-nodes,factory-defaults,preset";
const DEVICE: [&str; 4] = ["--node", "10", "--device", "reference-301"];

/// Objects of the communication profile or of the application that keep a value.
const OBJECTS: [&str; 12] = [
    "1005", "1014", "1015", "1016:01", "1017", "1400:01", "1800:01", "1800:02", "1800:03", "1800:05", "1A00:00", "2041",
];

/// A trait of a firmware, and the cases in which it shows.
struct Trait {
    interface: &'static str,
    /// Options of `canvass simulate`.
    firmware: &'static [&'static str],
    select: &'static str,
}

impl Trait {
    fn start(&self) -> (Interface, Running) {
        let bus = Interface::new(self.interface);
        let device = simulate("reference-301", bus.name(), self.firmware);
        eventually("the device has booted", || read(bus.name(), "1000").0);
        (bus, device)
    }

    /// No case fails or stays inconclusive, the dictionary is unchanged, and the fuzzer finds no violation.
    fn is_spared(&self) {
        let (bus, device) = self.start();
        let before = dictionary(bus.name());
        let report = tested(bus.name(), self.select);
        assert_eq!(ending(&report, &["fail", "error", "inconclusive"]), BTreeSet::new(), "{}", brief(&report));
        assert!(!ending(&report, &["pass"]).is_empty(), "{}", brief(&report));
        assert_eq!(dictionary(bus.name()), before);
        let fuzzed = fuzzed(bus.name());
        assert_eq!(fuzzed["violations"], Value::Array(Vec::new()), "{fuzzed:#}");
        assert_eq!(dictionary(bus.name()), before, "after fuzzing");
        assert_eq!(device.interrupt().status, 0);
    }

    /// The case during which the device dies fails and reports it, and the fuzzer reports the device as dead.
    fn is_dead_after(&self, culprit: &str) {
        let (bus, device) = self.start();
        let report = tested(bus.name(), self.select);
        assert_eq!(ending(&report, &["fail", "error"]), BTreeSet::from([culprit.to_owned()]), "{}", brief(&report));
        let said = brief(&report);
        assert!(said.contains(&format!("it stopped answering during {culprit}")), "{said}");
        drop(device);
        let _again = simulate("reference-301", bus.name(), self.firmware);
        let fuzzed = fuzzed(bus.name());
        let mut violations = fuzzed["violations"].as_array().unwrap().iter();
        assert!(fuzzed["dead"] == true && violations.any(|violation| violation["property"] == ALIVE), "{fuzzed:#}");
    }
}

/// The values of the objects; a refusal counts as a value.
fn dictionary(bus: &str) -> BTreeMap<&'static str, (bool, String)> {
    OBJECTS.into_iter().map(|object| (object, read(bus, object))).collect()
}

/// Whether the object can be read, and its printed value.
fn read(bus: &str, object: &str) -> (bool, String) {
    let read = run(&["sdo", "read", bus, "10", object, "--timeout", "3s"]);
    (read.status.success(), text(&read.stdout))
}

fn tested(bus: &str, select: &str) -> Value {
    let more = ["--select", select, "--allow", ALLOWED, "--format", "json", "--journal", "none"];
    let output = run(&[&["test", bus], &DEVICE[..], &more].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

fn fuzzed(bus: &str) -> Value {
    let output = run(&[&["fuzz", bus], &DEVICE[..], &["--seed", "1", "--for", "20s", "--format", "json"]].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

/// The cases with one of these verdicts.
fn ending(report: &Value, verdicts: &[&str]) -> BTreeSet<String> {
    let cases = report["cases"].as_array().unwrap().iter();
    let ends = |case: &&Value| verdicts.contains(&case["verdict"].as_str().unwrap());
    cases.filter(ends).map(|case| case["id"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn refuses_while_valid() {
    let firmware = &["--liberty", "pdo-parameters-locked", "--liberty", "cob-id-rewrite-refused"];
    Trait { interface: "vlocked", firmware, select: "301/tpdo,301/cob-id,301/emcy" }.is_spared();
}

#[test]
fn pdos_off() {
    Trait { interface: "voff", firmware: &["--liberty", "pdos-invalid"], select: "301/tpdo" }.is_spared();
}

#[test]
fn loses_its_node_id() {
    Trait { interface: "vlost", firmware: &["--liberty", "node-id-restored"], select: "301/restore" }.is_spared();
}

#[test]
fn restarts_in_5_s() {
    Trait { interface: "vslow5", firmware: &["--liberty", "restart-in-5-s"], select: "301/nmt,301/emcy" }.is_spared();
}

#[test]
fn answers_in_900_ms() {
    Trait { interface: "vslow9", firmware: &["--liberty", "answers-in-900-ms"], select: "301/heartbeat,301/sync" }
        .is_spared();
}

#[test]
fn hangs_in_a_case() {
    let (firmware, select) = (&["--fault", "heartbeat-consumer-hangs"], "301/heartbeat-consumer");
    Trait { interface: "vhangs", firmware, select }.is_dead_after("301/heartbeat-consumer/no-node");
}

#[test]
fn dies_after_a_reset() {
    let (firmware, select) = (&["--fault", "reset-when-stopped-hangs"], "301/error-behaviour");
    Trait { interface: "vdiesr", firmware, select }.is_dead_after("301/error-behaviour/only-operational");
}

/// The tester writes back the values that a reset would restore on other devices. Cases about resets are not selected
/// here.
#[test]
fn keeps_ram_over_reset() {
    let firmware = &["--fault", "nmt-reset-node-keeps-parameters"];
    let kept = Trait { interface: "vram", firmware, select: "301/tpdo,301/emcy,301/heartbeat" };
    let (bus, device) = kept.start();
    let before = dictionary(bus.name());
    let report = tested(bus.name(), kept.select);
    assert_eq!(ending(&report, &["fail", "error", "inconclusive"]), BTreeSet::new(), "{}", brief(&report));
    assert_eq!(dictionary(bus.name()), before);
    assert_eq!(device.interrupt().status, 0);
}
