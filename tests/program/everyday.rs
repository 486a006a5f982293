//! Everyday options of `canvass test`: selections, the failures of the last run, forecasts.

use crate::running::run;
use serde_json::Value;

const FAULTY: &str = "sim:kuebler-sendix-58x8+boot-up-twice";
const FAILING: [&str; 2] = ["301/boot-up/reset-communication", "301/boot-up/reset-node"];

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn ids(report: &Value) -> Vec<String> {
    let cases = report["cases"].as_array().unwrap();
    cases.iter().map(|case| case["id"].as_str().unwrap().to_owned()).collect()
}

fn tested(args: &[&str]) -> (i32, Value) {
    let ended = run(&[&["test"], args, &["--format", "json"]].concat());
    (ended.status, json(&ended.stdout))
}

#[test]
fn what_failed_runs_again() {
    let folder = tempfile::tempdir().unwrap();
    let result = folder.path().join("result.json").display().to_string();
    let select = ["--select", "301/boot-up,301/identity"];
    let first = run(&[&["test", FAULTY, "--report", &format!("json={result}")], &select[..]].concat());
    assert_eq!(first.status, 1, "{}", first.stderr);
    let (status, again) = tested(&[FAULTY, "--failed-from", &result]);
    assert_eq!((status, ids(&again)), (1, FAILING.map(str::to_owned).to_vec()));
    let (status, _) =
        tested(&["sim:kuebler-sendix-58x8", "--failed-from", &result, "--exclude", "301/boot-up/reset-node"]);
    assert_eq!(status, 0);
    // If no case failed, nothing is tested, which is no success.
    let good = folder.path().join("good.json").display().to_string();
    run(&["test", FAULTY, "--select", "301/identity", "--report", &format!("json={good}")]);
    let none = run(&["test", FAULTY, "--failed-from", &good]);
    assert_eq!(none.status, 3);
    assert!(none.stderr.contains("no failed case that could run again"), "{}", none.stderr);
    assert_eq!(run(&["test", FAULTY, "--failed-from", "Cargo.toml"]).status, 2);
}

#[test]
fn the_shards_are_all_cases_each_once() {
    let (_, whole) = tested(&[FAULTY, "--select", "301/boot-up,301/identity"]);
    let mut parts: Vec<String> = (1..=3)
        .flat_map(|n| ids(&tested(&[FAULTY, "--select", "301/boot-up,301/identity", "--shard", &format!("{n}/3")]).1))
        .collect();
    parts.sort();
    assert_eq!(parts, ids(&whole));
    assert_eq!(run(&["test", FAULTY, "--shard", "4/3"]).status, 2);
    assert_eq!(run(&["test", FAULTY, "--select", FAILING[0], "--shard", "2/2"]).status, 3);
}

#[test]
fn what_is_excluded_does_not_run() {
    let (status, report) = tested(&[FAULTY, "--select", "301/boot-up", "--exclude", "301/*/reset-*"]);
    assert!(status == 0 && ids(&report).iter().all(|id| !id.contains("/reset-")), "{report}");
    let idle = run(&["test", FAULTY, "--exclude", "301/boot-upp"]);
    assert_eq!(idle.status, 3);
    assert!(idle.stderr.contains("--exclude 301/boot-upp selects none"), "{}", idle.stderr);
    assert_eq!(run(&["test", FAULTY, "--select", "301/boot-up", "--exclude", "301"]).status, 3);
}

#[test]
fn the_first_failure_ends_the_run() {
    let (status, report) = tested(&[FAULTY, "--select", "301/boot-up,301/identity", "--fail-fast"]);
    assert_eq!((status, &report["cancelled"], &report["summary"]["fail"]), (1, &true.into(), &1.into()));
    assert_eq!(ids(&report).last().map(String::as_str), Some(FAILING[0]));
    let notice = report["notices"][0].as_str().unwrap();
    assert!(notice.ends_with("a case failed, and the run ends with the first failure"), "{notice}");
}

/// A case that fails at each try fails; the notes list all tries.
#[test]
fn a_failure_that_stays_fails_whatever_the_retries() {
    let (status, report) = tested(&[FAULTY, "--select", FAILING[1], "--retries", "2"]);
    let case = &report["cases"][0];
    assert_eq!((status, &case["verdict"], &case["flaky"]), (1, &"fail".into(), &false.into()));
    assert_eq!(case["repetitions"].as_array().unwrap().len(), 3);
    assert!(case["notes"][0].as_str().unwrap().starts_with("try 1 ended with fail"), "{case}");
    assert_eq!(run(&["test", FAULTY, "--retries", "2", "--repeat", "2"]).status, 2);
}

#[test]
fn a_forecast_refuses_what_the_run_refuses() {
    for (args, status) in [
        (&["test", "can0", "--device", "/no/such.eds"][..], 2),
        (&["test", "can0"], 2),
        (&["test", "sim:kuebler-sendix-m58"], 2),
        (&["test", "sim:kuebler-sendix-58x8:63", "--node", "5"], 3),
        (&["test", FAULTY, "--report", "html=/no/such/folder/x.html"], 2),
        (&["test", FAULTY, "--waivers", "Cargo.toml"], 2),
        (&["test", FAULTY, "--record", "Cargo.log.unknown"], 2),
        (&["test", FAULTY, "--select", "301/store/persists"], 3),
    ] {
        let (run_status, dry) = (run(args), run(&[args, &["--dry-run"]].concat()));
        assert_eq!(dry.status, status, "{args:?}: {}", dry.stderr);
        // The dry run cannot predict an error of the bus itself.
        let touches_bus = args.contains(&"can0");
        assert!(touches_bus || run_status.status == status, "{args:?}: {}", run_status.stderr);
    }
}

#[test]
fn a_forecast_counts_only_what_would_run() {
    let args = ["test", "sim:reference-301", "--select", "301/store,301/identity"];
    let forecast = json(&run(&[&args[..], &["--dry-run", "--format", "json"]].concat()).stdout);
    assert_eq!(forecast["schema"], "canvass/dry-run/1");
    let (_, report) = tested(&args[1..]);
    let ran = |case: &&Value| case["verdict"] != "not_applicable";
    let run_count = report["cases"].as_array().unwrap().iter().filter(ran).count();
    assert_eq!(forecast["would_run"], run_count);
    let nvm = forecast["cases"].as_array().unwrap().iter().find(|case| case["id"] == "301/store/persists").unwrap();
    assert_eq!((&nvm["runs"], &nvm["reason"]), (&false.into(), &"only with --allow nvm".into()));
}

/// The device's own description decides: the cases of heartbeat and EMCY do not apply to a device without both
/// services.
#[test]
fn a_forecast_knows_the_device_of_a_description() {
    let folder = tempfile::tempdir().unwrap();
    let eds = folder.path().join("poor.eds").display().to_string();
    let text = "[FileInfo]\nFileName=poor.eds\n[DeviceInfo]\nVendorName=x\nBaudRate_250=1\n[DummyUsage]\n\
                [MandatoryObjects]\nSupportedObjects=3\n1=0x1000\n2=0x1001\n3=0x1018\n\
                [1000]\nParameterName=Device type\nDataType=7\nAccessType=ro\nDefaultValue=0\n\
                [1001]\nParameterName=Error register\nDataType=5\nAccessType=ro\nDefaultValue=0\n\
                [1018]\nParameterName=Identity\nObjectType=9\nSubNumber=2\n\
                [1018sub0]\nParameterName=Highest\nDataType=5\nAccessType=ro\nDefaultValue=1\n\
                [1018sub1]\nParameterName=Vendor\nDataType=7\nAccessType=ro\nDefaultValue=1\n\
                [OptionalObjects]\nSupportedObjects=0\n[ManufacturerObjects]\nSupportedObjects=0\n";
    std::fs::write(&eds, text).unwrap();
    let args =
        ["test", "can0", "--node", "5", "--select", "301/heartbeat,301/identity", "--dry-run", "--format", "json"];
    let rich = json(&run(&[&args[..], &["--device", "kuebler-sendix-58x8"]].concat()).stdout);
    let poor = run(&[&args[..], &["--device", &eds]].concat());
    let poor = json(&poor.stdout);
    let period = |forecast: &Value| {
        let cases = forecast["cases"].as_array().unwrap();
        cases.iter().find(|case| case["id"] == "301/heartbeat/period").unwrap()["runs"].clone()
    };
    assert_eq!((period(&rich), period(&poor)), (true.into(), false.into()));
    assert_eq!(poor["like"], eds);
}

#[test]
fn a_simulated_device_gets_the_node_id_that_is_asked_for() {
    let (status, report) = tested(&["sim:kuebler-sendix-m58", "--node", "5", "--select", "301/identity"]);
    assert_eq!((status, &report["node"]), (0, &5.into()));
    let without = run(&["test", "sim:kuebler-sendix-m58"]);
    assert_eq!(without.status, 2);
    assert!(
        without.stderr.contains("kuebler-sendix-m58 has no node-ID as delivered: assign one with --node N"),
        "{}",
        without.stderr
    );
    let read = run(&["sdo", "read", "sim:kuebler-sendix-58x8", "9", "1018:1"]);
    assert_eq!(read.status, 0, "{}", read.stderr);
}

/// With a single fault, the selftest does not judge whether the cases of this fault detect other faults.
#[test]
fn the_selftest_of_a_fault_judges_what_belongs_to_it() {
    let tested = run(&["selftest", "--fault", "heartbeat-period-doubled", "--format", "json"]);
    assert_eq!(tested.status, 0, "{}{}", tested.stdout, tested.stderr);
    let report = json(&tested.stdout);
    assert_eq!((&report["summary"]["faults"], &report["summary"]["detected"]), (&1.into(), &1.into()));
    assert_eq!(report["models"].as_array().unwrap().len(), 1);
    let elsewhere = run(&["selftest", "--fault", "heartbeat-period-doubled", "--select", "305"]);
    assert_eq!(elsewhere.status, 3, "{}", elsewhere.stderr);
}

#[test]
fn the_result_ends_with_what_failed() {
    let shown = run(&["test", FAULTY, "--select", "301/boot-up,301/identity"]).stdout;
    let last: Vec<&str> = shown.lines().rev().take(2).collect();
    assert!(last[1].starts_with("✗ 301/boot-up/reset-communication  "), "{shown}");
    assert!(last[1].contains("expected boot-up, found"), "{last:?}");
    assert_eq!(last[0].trim(), "the same: 301/boot-up/reset-node", "{shown}");
}

/// A misspelt name is asked for, and a description that is taken for a capture says what it is for.
#[test]
fn mistakes_are_understood() {
    for (args, says) in [
        (&["explain", "301/sdo/downlod/read-only"][..], "(is 301/sdo/download/read-only meant?)"),
        (&["test", "sim:reference-301+boot-up-twise"], "(is boot-up-twice meant?)"),
        (
            &["sdo", "read", "sim:reference-301", "10", "1000", "--device", "kubler-sendix-58x8"],
            "(is kuebler-sendix-58x8 meant?)",
        ),
        (&["decode", "conformance/device/models/tr-c65.eds"], "--device NODE=FILE"),
    ] {
        let refused = run(args);
        assert!(refused.status == 2 && refused.stderr.contains(says), "{args:?}: {}", refused.stderr);
    }
}
