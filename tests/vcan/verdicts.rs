//! A case can't tell which bus it runs on: verdicts on vcan are those on the simulated bus, for every model.

use crate::interface::Interface;
use crate::running::{run, simulate, text};
use serde_json::Value;
use std::collections::BTreeMap;

type Verdicts = BTreeMap<String, String>;

/// How often cases are repeated that could not be judged because this machine was too slow.
const REPETITIONS: usize = 4;

const INTERFACES: [&str; 24] = [
    "vm0", "vm1", "vm2", "vm3", "vm4", "vm5", "vm6", "vm7", "vm8", "vm9", "vm10", "vm11", "vm12", "vm13", "vm14",
    "vm15", "vm16", "vm17", "vm18", "vm19", "vm20", "vm21", "vm22", "vm23",
];

fn report(args: &[&str]) -> Value {
    let output = run(&[&["test"], args, &["--format", "json"]].concat());
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

fn verdicts(report: &Value) -> Verdicts {
    let cases = report["cases"].as_array().unwrap().iter();
    let text = |case: &Value, key: &str| case[key].as_str().unwrap().to_owned();
    cases.map(|case| (text(case, "id"), text(case, "verdict"))).collect()
}

/// The cases of which the report says that this machine, not the device, was too slow.
fn too_slow(report: &Value) -> Vec<String> {
    let cases = report["cases"].as_array().unwrap().iter();
    let is_late = |case: &&Value| case["reason"]["duty"] == "the tester's machine keeps up";
    cases.filter(is_late).map(|case| case["id"].as_str().unwrap().to_owned()).collect()
}

/// The cases that take no longer than [`BUDGET`] together: every n-th where all of them would take longer, as with devices
/// that send no boot-up message, whose every start is waited for.
fn affordable(report: &Value) -> String {
    let whole = report["duration_ns"].as_u64().unwrap();
    let step = usize::try_from(whole.div_ceil(BUDGET)).unwrap();
    let ids = report["cases"].as_array().unwrap().iter().map(|case| case["id"].as_str().unwrap());
    ids.step_by(step.max(1)).collect::<Vec<_>>().join(",")
}

/// Nanoseconds on the bus.
const BUDGET: u64 = 150_000_000_000;

fn agrees(model: &str, node: &str, interface: &'static str) {
    let simulated = report(&[&format!("sim:{model}"), "--node", node]);
    let select = affordable(&simulated);
    let expected = verdicts(&report(&[&format!("sim:{model}"), "--node", node, "--select", &select]));
    let bus = Interface::new(interface);
    let device = simulate(model, bus.name(), &["--node", node]);
    let args = [bus.name(), "--node", node, "--device", model];
    let mut found = report(&[&args[..], &["--select", &select]].concat());
    let mut verdicts_found = verdicts(&found);
    println!("{model}: {} of {} cases, host {}", expected.len(), verdicts(&simulated).len(), found["host"]);
    for _ in 0..REPETITIONS {
        let again = too_slow(&found).join(",");
        if again.is_empty() {
            break;
        }
        found = report(&[&args[..], &["--select", &again]].concat());
        verdicts_found.extend(verdicts(&found));
    }
    let ended = device.interrupt();
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    let different = expected.iter().filter(|(id, verdict)| verdicts_found.get(*id) != Some(verdict));
    let different: Vec<_> = different.map(|(id, verdict)| (id, verdict, verdicts_found.get(id))).collect();
    assert!(different.is_empty(), "{model}: id, on the simulated bus, on vcan: {different:#?}");
    assert_eq!(expected.len(), verdicts_found.len());
}

/// A model whose node-ID is set by LSS first is given one here.
const SOME_NODE: u64 = 5;

#[test]
fn every_model_gets_the_same_verdicts() {
    let models: Value = serde_json::from_slice(&run(&["list", "models", "--format", "json"]).stdout).unwrap();
    let models = models.as_array().unwrap();
    assert!(models.len() <= INTERFACES.len());
    std::thread::scope(|scope| {
        for (model, interface) in models.iter().zip(INTERFACES) {
            let node = model["node"].as_u64().unwrap_or(SOME_NODE).to_string();
            scope.spawn(move || agrees(model["id"].as_str().unwrap(), &node, interface));
        }
    });
}

/// A fault shows on vcan as it does on the simulated bus.
#[test]
fn a_faulty_device_fails_on_vcan_too() {
    let bus = Interface::new("vfaulty");
    let _device = simulate("kuebler-sendix-58x8", bus.name(), &["--fault", "sdo-toggle-unchecked"]);
    let found = report(&[bus.name(), "--device", "kuebler-sendix-58x8", "--select", "301/sdo/download/segment-toggle"]);
    assert_eq!(verdicts(&found)["301/sdo/download/segment-toggle"], "fail", "{found}");
}
