//! Faults of a bus and its users: interfaces that go down, processes that die, nodes that babble, users who interrupt.

use crate::interface::{Interface, transmitted};
use crate::running::{Running, brief, canvass, eventually, run, simulate, text};
use serde_json::Value;
use std::io::Write as _;
use std::process::{Command, Stdio};
use std::time::Duration;

const MODEL: &str = "kuebler-sendix-58x8";

/// Starts `test` with a few cases that take some seconds.
fn start_test(bus: &Interface, select: &str, more: &[&str]) -> Running {
    let args = ["test", bus.name(), "--device", MODEL, "--format", "json", "--select", select];
    Running::start(canvass(&[&args[..], more].concat()))
}

fn parsed(stdout: &str) -> Value {
    serde_json::from_str(stdout).unwrap_or_else(|error| panic!("the report is complete: {error}: {stdout}"))
}

fn count(report: &Value, verdict: &str) -> u64 {
    report["summary"][verdict].as_u64().unwrap()
}

fn reads(bus: &Interface, object: &str) -> String {
    let output = run(&["sdo", "read", bus.name(), "63", object]);
    format!("{}{}", text(&output.stdout), text(&output.stderr))
}

#[test]
fn an_interface_goes_down_and_up_during_test_and_simulate() {
    let bus = Interface::new("vdown");
    let device = simulate(MODEL, bus.name(), &[]);
    let test = start_test(&bus, "301/nmt", &[]);
    std::thread::sleep(Duration::from_secs(6));
    bus.down();
    std::thread::sleep(Duration::from_millis(500));
    bus.up();
    let ended = test.finish();
    let report = parsed(&ended.stdout);
    assert_eq!(count(&report, "fail"), 0, "{}", brief(&report));
    assert!(count(&report, "error") >= 1, "{}", brief(&report));
    assert!(count(&report, "pass") >= 1, "it goes on when the bus is back: {}", brief(&report));
    let said = |case: &Value| case["reason"]["actual"].as_str().unwrap_or_default().contains("vdown");
    assert!(report["cases"].as_array().unwrap().iter().any(said), "{}", brief(&report));
    assert!(ended.status == 1, "{}", ended.stderr);
    // The device has survived the interruption.
    assert!(reads(&bus, "1000").contains("1000h:00"));
    assert_eq!(device.interrupt().status, 0);
}

/// Sequences during the interruption are not judged; sequences before and after it are judged.
#[test]
fn an_interface_goes_down_and_up_during_fuzz() {
    let bus = Interface::new("vfuzzdown");
    let device = simulate("reference-301", bus.name(), &[]);
    let args = ["fuzz", bus.name(), "--node", "10", "--device", "reference-301", "--target", "sdo", "--seed", "1"];
    let fuzz = Running::start(canvass(&[&args[..], &["--for", "12s", "--format", "json"]].concat()));
    std::thread::sleep(Duration::from_secs(5));
    bus.down();
    std::thread::sleep(Duration::from_millis(1_200));
    bus.up();
    let ended = fuzz.finish();
    let report = parsed(&ended.stdout);
    let brief = format!("{} {} {}", report["interruptions"], report["unjudged"], report["violations"]);
    assert_eq!((ended.status, &report["violations"]), (0, &Value::Array(Vec::new())), "{brief}");
    assert_eq!(
        (&report["interruptions"]["count"], &report["interruptions"]["over"]),
        (&1.into(), &true.into()),
        "{brief}"
    );
    assert!(report["interruptions"]["duration_ns"].as_u64().unwrap() >= 1_150_000_000, "{brief}");
    assert!((1..=3).contains(&report["unjudged"].as_u64().unwrap()), "{brief}");
    assert!(report["left"]["compared"].as_u64().unwrap() > 10, "the device is read at the end: {}", report["left"]);
    assert_eq!(device.interrupt().status, 0);
}

#[test]
fn an_interface_goes_down_and_up_during_record() {
    let bus = Interface::new("vrecdown");
    let path = std::env::temp_dir().join("canvass-recdown.log");
    let mut record = Running::start(canvass(&["record", bus.name(), path.to_str().unwrap(), "--force"]));
    record.says("recording");
    let send = |id: &str| assert!(Command::new("cansend").args([bus.name(), id]).status().unwrap().success());
    send("101#01");
    std::thread::sleep(Duration::from_millis(300));
    bus.down();
    let told = record.says("went down");
    assert!(told.contains("recording goes on"), "{told}");
    bus.up();
    std::thread::sleep(Duration::from_millis(300));
    send("102#02");
    std::thread::sleep(Duration::from_millis(300));
    let ended = record.interrupt();
    assert!(ended.stderr.contains("2 frames recorded, 0 lost, 1 interruption of the bus"), "{}", ended.stderr);
    let recorded = std::fs::read_to_string(path).unwrap();
    assert!(recorded.contains("101#01") && recorded.contains("102#02"), "{recorded}");
}

#[test]
fn a_removed_interface_is_found_again() {
    let bus = Interface::new("vremoved");
    let path = std::env::temp_dir().join("canvass-removed.log");
    let mut record = Running::start(canvass(&["record", bus.name(), path.to_str().unwrap(), "--force"]));
    record.says("recording");
    drop(bus);
    std::thread::sleep(Duration::from_millis(300));
    let bus = Interface::new("vremoved");
    std::thread::sleep(Duration::from_millis(500));
    assert!(Command::new("cansend").args([bus.name(), "103#03"]).status().unwrap().success());
    std::thread::sleep(Duration::from_millis(500));
    let ended = record.interrupt();
    assert!(std::fs::read_to_string(path).unwrap().contains("103#03"), "{}", ended.stderr);
}

/// Number of segment requests in the preparation of `301/sdo` and in its first case.
const EARLIER: usize = 23;

/// Waits until the tester requests a segment of an upload in one of the cases; `act` then ends a process in the middle
/// of this transfer.
fn in_mid_transfer(bus: &Interface, act: impl FnOnce()) {
    let mut candump = Command::new("candump");
    // The filter of candump passes the SDO requests, whose segment requests have either toggle bit.
    candump.args(["-L", &format!("{},63F:7FF", bus.name())]).stdin(Stdio::null());
    let mut candump = Running::start(candump);
    candump.prints(&["63F#60", "63F#70"], EARLIER + 1);
    act();
}

#[test]
fn a_device_that_dies_in_mid_transfer_fails_that_case_alone() {
    let bus = Interface::new("vdies");
    let device = simulate(MODEL, bus.name(), &[]);
    let test = start_test(&bus, "301/sdo", &[]);
    in_mid_transfer(&bus, || device.kill());
    let ended = test.finish();
    let report = parsed(&ended.stdout);
    assert_eq!(count(&report, "fail"), 1, "{}", brief(&report));
    let cases = report["cases"].as_array().unwrap();
    let failed = cases.iter().find(|case| case["verdict"] == "fail").unwrap();
    let says = |case: &Value, what: &str| case["breaches"].to_string().contains(what);
    assert!(says(failed, "the device stopped answering"), "{failed:#}");
    // The following cases name this case as the cause.
    assert!(count(&report, "inconclusive") >= 2, "{}", brief(&report));
    let last = &cases.last().unwrap()["reason"]["actual"];
    assert!(last.as_str().unwrap().contains(failed["id"].as_str().unwrap()), "{last}");
    assert_eq!(ended.status, 1);
}

#[test]
fn a_tester_that_dies_in_mid_transfer_leaves_a_device_that_works() {
    let bus = Interface::new("vtester");
    let device = simulate(MODEL, bus.name(), &[]);
    let test = start_test(&bus, "301/sdo", &[]);
    in_mid_transfer(&bus, || test.kill());
    // The killed run has left its journal: the next run restores the device first.
    let ended = start_test(&bus, "301/sdo/upload", &["--restore"]).finish();
    assert_eq!(ended.status, 0, "{}", ended.stdout);
    assert_eq!(device.interrupt().status, 0);
}

/// A node fills the bus during the suite, with an identifier of the highest priority. A bus of 1 Mbit/s carries about 8
/// 000 of its frames per second.
#[test]
fn a_babbling_node_is_not_the_devices_fault() {
    let bus = Interface::new("vbabble");
    let device = simulate(MODEL, bus.name(), &[]);
    let mut cangen = Command::new("cangen");
    cangen.args(["-g", "0.1", "-I", "001", "-L", "8", "-i", bus.name()]).stdin(Stdio::null());
    let babbler = Running::start(cangen);
    let select = "301/sdo/upload/expedited,301/sdo/upload/segmented,301/heartbeat/extremes";
    let ended = start_test(&bus, select, &[]).finish();
    let report = parsed(&ended.stdout);
    assert_eq!(count(&report, "fail"), 0, "{}", brief(&report));
    let judged: u64 = report["summary"].as_object().unwrap().values().filter_map(Value::as_u64).sum();
    assert_eq!((report["cases"].as_array().unwrap().len(), judged), (3, 3), "{}", brief(&report));
    writeln!(std::io::stderr(), "figure: babbling: {} host {}", report["summary"], report["host"]).unwrap();
    // When the bus is quiet again, the device is as it was.
    babbler.kill();
    let time = reads(&bus, "1017");
    assert!(time.contains("= 0"), "{time}");
    assert_eq!(device.interrupt().status, 0);
}

/// A program floods the bus for a second with more frames than any bus carries. The flood outlasts every wait of the
/// tester; cases that lost frames are not judged, and the run goes on afterwards.
#[test]
fn a_flood_ends_no_run_and_fails_nothing() {
    let bus = Interface::new("vflood");
    let device = simulate(MODEL, bus.name(), &[]);
    let test = start_test(&bus, "301/heartbeat/extremes,301/sdo/upload", &[]);
    std::thread::sleep(Duration::from_secs(3));
    let mut cangen = Command::new("cangen");
    cangen.args(["-g", "0", "-I", "001", "-L", "0", "-i", bus.name()]).stdin(Stdio::null());
    let flood = Running::start(cangen);
    std::thread::sleep(Duration::from_secs(1));
    flood.kill();
    let ended = test.finish();
    let report = parsed(&ended.stdout);
    let frames = transmitted(bus.name());
    writeln!(std::io::stderr(), "figure: flood: {frames} frames, {} host {}", report["summary"], report["host"])
        .unwrap();
    assert_eq!((count(&report, "fail"), count(&report, "error")), (0, 0), "{}", brief(&report));
    assert!(count(&report, "pass") >= 3, "{}", brief(&report));
    let is_inconclusive = |case: &&Value| case["verdict"] == "inconclusive";
    let is_the_floods = |case: &Value| {
        let found = case["reason"]["actual"].as_str().unwrap_or_default();
        found.contains("frames were lost") || found.contains("of the bus")
    };
    assert!(
        report["cases"].as_array().unwrap().iter().filter(is_inconclusive).all(is_the_floods),
        "{}",
        brief(&report)
    );
    // The last cases run after the flood.
    assert_ne!(report["cases"].as_array().unwrap().last().unwrap()["verdict"], "inconclusive", "{}", brief(&report));
    let time = reads(&bus, "1017");
    assert!(time.contains("= 0"), "{time}");
    assert_eq!(device.interrupt().status, 0);
}

#[test]
fn ctrl_c_restores_the_device_and_writes_the_report() {
    let bus = Interface::new("vctrlc");
    let _device = simulate(MODEL, bus.name(), &[]);
    assert!(text(&run(&["nmt", bus.name(), "start", "63", "--wait", "50ms"]).stdout).contains("000"));
    let test = start_test(&bus, "301/heartbeat", &[]);
    std::thread::sleep(Duration::from_secs(9));
    let ended = test.interrupt();
    let report = parsed(&ended.stdout);
    assert_eq!(report["cancelled"], true, "{}", brief(&report));
    assert_eq!(count(&report, "fail"), 0);
    assert_eq!(ended.status, 1, "{}", ended.stderr);
    // The heartbeat time that the case had set is 0 again, as delivered.
    let time = reads(&bus, "1017");
    assert!(time.contains("= 0"), "{time}");
}

/// The tester distinguishes its own frames from frames of others on the same machine.
#[test]
fn own_frames_are_told_from_others() {
    let bus = Interface::new("vown");
    let _device = simulate(MODEL, bus.name(), &[]);
    let report = parsed(&start_test(&bus, "301/sdo/upload", &[]).finish().stdout);
    let frames: Vec<&Value> =
        report["cases"].as_array().unwrap().iter().flat_map(|case| case["evidence"].as_array().unwrap()).collect();
    let direction = |id: u64| -> Vec<&str> {
        let of = frames.iter().filter(|frame| frame["id"] == id);
        of.map(|frame| frame["direction"].as_str().unwrap()).collect()
    };
    let (requests, responses) = (direction(0x63F), direction(0x5BF));
    assert!(!requests.is_empty() && requests.iter().all(|direction| *direction == "tx"), "{requests:?}");
    assert!(!responses.is_empty() && responses.iter().all(|direction| *direction == "rx"), "{responses:?}");
}

#[test]
fn errors_name_the_remedy() {
    let said = |bus: &str| {
        let output = run(&["test", bus, "--node", "5"]);
        assert_eq!(output.status.code(), Some(3));
        text(&output.stderr)
    };
    let bus = Interface::new("verrors");
    bus.down();
    assert!(said(bus.name()).contains("verrors is down: ip link set verrors up"), "{}", said(bus.name()));
    assert!(said("no-such-can").contains("there is no interface no-such-can"));
    assert!(said("lo").contains("lo is no CAN interface"), "{}", said("lo"));
    eventually("the interface comes up", || {
        bus.up();
        said(bus.name()).contains("does not answer")
    });
}
