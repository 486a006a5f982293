//! A case can't tell which bus it runs on: the verdicts on vcan equal those on the simulated bus, for every model and
//! every case.

use crate::interface::Interface;
use crate::running::{Running, brief, canvass, run, simulate, text};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write as _;

type Verdicts = BTreeMap<String, String>;

/// Maximum number of repetitions of cases that were not judged because this machine was too slow.
const REPETITIONS: usize = 4;

/// The permissions that a verdict on these simulated devices may need; each device is alone on its bus.
const ALLOWED: &str = "nvm,node-id,bit-rate,other-nodes,factory-defaults,preset";

fn report(args: &[&str]) -> Value {
    let output = run(&[&["test"], args, &["--allow", ALLOWED, "--format", "json"]].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

fn verdicts(report: &Value) -> Verdicts {
    let cases = report["cases"].as_array().unwrap().iter();
    let text = |case: &Value, key: &str| case[key].as_str().unwrap().to_owned();
    cases.map(|case| (text(case, "id"), text(case, "verdict"))).collect()
}

/// The cases that were not judged because this machine, not the device, was too slow.
fn too_slow(report: &Value) -> Vec<String> {
    let cases = report["cases"].as_array().unwrap().iter();
    let is_late = |case: &&Value| case["reason"]["duty"] == "the tester's machine keeps up";
    cases.filter(is_late).map(|case| case["id"].as_str().unwrap().to_owned()).collect()
}

/// The reason that the report gives for a verdict, for the message of a failed test.
fn reason<'a>(report: &'a Value, id: &str) -> &'a Value {
    let case = report["cases"].as_array().unwrap().iter().find(|case| case["id"] == id);
    case.map_or(&Value::Null, |case| &case["reason"])
}

/// Cases that need to know the bit rate of the bus, which a vcan lacks: the first four run on controllers
/// (`controllers.rs`), the last case fills the bus, which only a real bus allows.
const OF_THE_BIT_RATE: [&str; 5] = [
    "205/bit-timing/activate",
    "205/bit-timing/takes-effect",
    "305/bit-timing/activate",
    "305/bit-timing/takes-effect",
    "301/sync/window",
];

/// The cases that together take no longer than [`BUDGET`]. In the tests' own machine, where waiting takes no time,
/// these are all cases. Elsewhere they are every n-th case, if all of them would take longer; this concerns devices
/// without boot-up message, whose every start has to be waited for.
fn affordable(report: &Value) -> Vec<&str> {
    let whole = report["duration_ns"].as_u64().unwrap();
    let is_own_machine = std::env::var_os("CANVASS_VCAN_OUT").is_some();
    let step = if is_own_machine { 1 } else { usize::try_from(whole.div_ceil(BUDGET)).unwrap() };
    let ids = report["cases"].as_array().unwrap().iter().map(|case| case["id"].as_str().unwrap());
    ids.step_by(step.max(1)).collect()
}

/// Time on the bus in nanoseconds.
const BUDGET: u64 = 400_000_000_000;

/// The node-ID of models that are delivered without one and get it by LSS.
const SOME_NODE: u64 = 63;

fn models() -> Vec<(String, String)> {
    let models: Value = serde_json::from_slice(&run(&["list", "models", "--format", "json"]).stdout).unwrap();
    let node = |model: &Value| model["node"].as_u64().unwrap_or(SOME_NODE).to_string();
    models.as_array().unwrap().iter().map(|model| (model["id"].as_str().unwrap().to_owned(), node(model))).collect()
}

/// The name of an interface for this model: Linux takes up to 15 characters, and the ids of models differ at their
/// ends.
fn interface(model: &str) -> String {
    format!("v-{}", &model[model.len().saturating_sub(13)..])
}

fn agrees(model: &str) {
    let (_, node) = models().into_iter().find(|(id, _)| id == model).unwrap();
    let simulated = report(&[&format!("sim:{model}:{node}"), "--node", &node]);
    let select = affordable(&simulated).join(",");
    let mut expected: Verdicts =
        verdicts(&simulated).into_iter().filter(|(id, _)| select.split(',').any(|case| case == id)).collect();
    for (_, verdict) in expected.iter_mut().filter(|(id, _)| OF_THE_BIT_RATE.contains(&id.as_str())) {
        "not_applicable".clone_into(verdict);
    }
    let bus = Interface::new(interface(model));
    let device = simulate(model, bus.name(), &["--node", &node]);
    let args = [bus.name(), "--node", &node, "--device", model];
    let mut found = report(&[&args[..], &["--select", &select]].concat());
    let mut verdicts_found = verdicts(&found);
    writeln!(std::io::stderr(), "figure: {model}: {} cases, host {}", expected.len(), found["host"]).unwrap();
    for _ in 0..REPETITIONS {
        let again = too_slow(&found).join(",");
        if again.is_empty() {
            break;
        }
        writeln!(std::io::stderr(), "figure: {model}: again {again}").unwrap();
        found = report(&[&args[..], &["--select", &again]].concat());
        verdicts_found.extend(verdicts(&found));
    }
    let ended = device.interrupt();
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let different = expected.iter().filter(|(id, verdict)| verdicts_found.get(*id) != Some(verdict));
    let different: Vec<_> =
        different.map(|(id, verdict)| (id, verdict, verdicts_found.get(id), reason(&found, id))).collect();
    assert!(different.is_empty(), "{model}: id, on the simulated bus, on vcan: {different:#?}");
    assert_eq!(expected.len(), verdicts_found.len());
}

/// One test for each model, so that a failure names the model.
macro_rules! models {
    ($($test:ident = $model:literal,)*) => {
        $(#[test]
        fn $test() {
            agrees($model);
        })*
    };
}

canvass_device::each_model!(models);

/// A fault shows on vcan as it does on the simulated bus.
#[test]
fn a_faulty_device_fails_on_vcan_too() {
    let bus = Interface::new("vfaulty");
    let _device = simulate("kuebler-sendix-58x8", bus.name(), &["--fault", "sdo-toggle-unchecked"]);
    let found = report(&[bus.name(), "--device", "kuebler-sendix-58x8", "--select", "301/sdo/download/segment-toggle"]);
    assert_eq!(verdicts(&found)["301/sdo/download/segment-toggle"], "fail", "{}", brief(&found));
}

/// Programs that don't clear `struct can_frame` still send classical frames: no frame becomes CAN FD, and no answer is
/// lost.
#[test]
fn dirty_padding_changes_no_verdict() {
    let bus = Interface::new("vdirt");
    let select = ["--device", "reference-301", "--select", "301/sdo"];
    let verdicts_of = |more: &[&str]| {
        let device = simulate("reference-301", bus.name(), more);
        let report = report(&[&[bus.name()], &select[..]].concat());
        assert_eq!(device.interrupt().status, 0);
        (verdicts(&report), brief(&report))
    };
    let (dirty, said) = verdicts_of(&["--liberty", "dirty-padding"]);
    let (clean, _) = verdicts_of(&[]);
    assert_eq!(dirty, clean, "{said}");
    assert!(dirty.values().filter(|verdict| *verdict == "pass").count() > 50, "{said}");
}

#[test]
fn a_recording_of_dirty_padding_holds_classical_frames() {
    let bus = Interface::new("vdirtrec");
    let device = simulate("reference-301", bus.name(), &["--liberty", "dirty-padding"]);
    let capture = std::env::temp_dir().join("canvass-vdirt.pcapng");
    let _ = std::fs::remove_file(&capture);
    let path = capture.to_str().unwrap();
    let recorder = Running::start(canvass(&["record", bus.name(), path, "--for", "3s"]));
    assert!(run(&["sdo", "read", bus.name(), "10", "1008:00", "--device", "reference-301"]).status.success());
    assert_eq!(recorder.finish().status, 0);
    assert_eq!(device.interrupt().status, 0);
    let decoded = text(&run(&["decode", path, "--format", "json"]).stdout);
    assert!(decoded.lines().filter(|line| line.contains("\"sdo\"")).count() >= 4, "{decoded}");
    assert!(!decoded.contains("\"fd\":true"), "{decoded}");
}
