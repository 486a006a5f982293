//! The connection to the bus is interrupted while a command runs: the command continues when the connection is back,
//! and keeps its results even if the connection does not come back.

use crate::live::Device;
use crate::proxy::Proxy;
use crate::running::{Run, command, finished, interrupt, run};
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

/// Durations of interruptions, from a moment that the device may not notice to the restart of a gateway.
const SPANS: [Duration; 3] = [Duration::from_millis(300), Duration::from_millis(1_200), Duration::from_secs(5)];

/// A fault that shows at once, with the frames that show it and the SLCAN line of the last of these frames.
const FAULT: &str = "sdo-toggle-unchecked";
const REPRODUCER: &str =
    "# canvass fuzz: PROP-02\n(0.000000) can0 60A#4010200000000000\n(0.100000) can0 60A#7000000000000000\n";
const LAST_FRAME: &str = "t60A87000000000000000";

/// A device behind a connection that can be cut.
struct Bench {
    device: Device,
    proxy: Proxy,
    folder: tempfile::TempDir,
}

impl Bench {
    fn new(faults: &[&str]) -> Self {
        let device =
            Device::of("reference-301", &faults.iter().flat_map(|fault| ["--fault", fault]).collect::<Vec<_>>());
        let adapter = device.bus.strip_prefix("slcan:tcp://").unwrap().parse().unwrap();
        Self { proxy: Proxy::start(adapter).unwrap(), device, folder: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    /// Starts a command; the argument `BUS` stands for the bus.
    fn start(&self, args: &[&str]) -> Child {
        let bus = self.proxy.bus();
        let args: Vec<&str> = args.iter().map(|arg| if *arg == "BUS" { &*bus } else { arg }).collect();
        command(&args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Starts the fuzzer with a sequence that shows the fault, and waits until the fuzzer has repeated it.
    fn start_fuzz(&self, more: &[&str]) -> Child {
        let regressions = self.path("regressions.log");
        std::fs::write(&regressions, REPRODUCER).unwrap();
        let args = ["fuzz", "BUS", "--node", "10", "--device", "reference-301", "--target", "sdo", "--seed", "3"];
        let child = self.start(&[&args[..], &["--regressions", &regressions, "--format", "json"], more].concat());
        self.proxy.wait("the fault is confirmed", || self.proxy.has_sent(LAST_FRAME, 3));
        self.proxy.wait_for_lines(100);
        child
    }
}

fn ended(child: Child) -> Run {
    finished(child.wait_with_output().unwrap())
}

fn json(run: &Run) -> Value {
    serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}{}", run.stdout, run.stderr))
}

/// Runs `act` for each span, each time on a bench of its own.
fn for_each_span(faults: &[&str], act: impl Fn(&Bench, Duration) + Sync) {
    std::thread::scope(|scope| {
        for span in SPANS {
            let act = &act;
            scope.spawn(move || act(&Bench::new(faults), span));
        }
    });
}

/// Checks the report of one interruption: it lasts from the cut until the adapter was open again.
fn was_interrupted(interruptions: &Value, span: Duration) {
    assert_eq!((&interruptions["count"], &interruptions["over"]), (&1.into(), &true.into()), "{interruptions}");
    let lasted = Duration::from_nanos(interruptions["duration_ns"].as_u64().unwrap());
    assert!(lasted + Duration::from_millis(50) >= span, "{span:?}: {interruptions}");
    assert!(interruptions["last"].as_str().unwrap().contains("was disconnected"), "{interruptions}");
}

#[test]
fn fuzz_goes_on_and_keeps_what_it_had_found() {
    for_each_span(&[FAULT], |bench, span| {
        let fuzz = bench.start_fuzz(&["--for", "10min"]);
        bench.proxy.cut_for(span);
        bench.proxy.wait_for_lines(400);
        assert!(interrupt(&fuzz));
        let fuzzed = ended(fuzz);
        let report = json(&fuzzed);
        assert_eq!(fuzzed.status, 1, "{}", fuzzed.stderr);
        was_interrupted(&report["interruptions"], span);
        let violations = report["violations"].as_array().unwrap();
        let of_fault = violations.iter().find(|violation| violation["property"] == "PROP-02");
        assert_eq!(of_fault.map(|violation| &violation["confirmed"]), Some(&true.into()), "{report:#}");
        assert!(report["unjudged"].as_u64().unwrap() >= 1, "{report:#}");
        assert_eq!((&report["ended_by"], &report["dead"]), (&Value::Null, &false.into()), "{report:#}");
        assert_eq!(report["left"]["different"], Value::Array(Vec::new()), "it is left as it was found: {report:#}");
        assert!(report["left"]["compared"].as_u64().unwrap() > 10, "{report:#}");
        assert_eq!(run(&["sdo", "read", &bench.device.bus, "10", "1000"]).status, 0);
    });
}

/// A healthy device gets no violation, however often the connection is interrupted.
#[test]
fn fuzz_blames_no_device_for_its_bus() {
    let bench = Bench::new(&[]);
    let args = ["fuzz", "BUS", "--node", "10", "--device", "reference-301", "--seed", "5", "--for", "20s"];
    let fuzz = bench.start(&[&args[..], &["--format", "json"]].concat());
    // The first interruption comes while the device is read, before anything is judged.
    for milliseconds in [100, 40, 700, 5, 250, 1_100] {
        bench.proxy.wait_for_lines(60);
        bench.proxy.cut_for(Duration::from_millis(milliseconds));
    }
    let fuzzed = ended(fuzz);
    let report = json(&fuzzed);
    assert_eq!((fuzzed.status, &report["violations"]), (0, &Value::Array(Vec::new())), "{report:#}");
    assert_eq!(report["interruptions"]["count"], 6, "{report:#}");
    assert!(report["unjudged"].as_u64().unwrap() <= 8, "no more than were under way: {report:#}");
    assert!(report["sequences"].as_u64().unwrap() > 6, "{report:#}");
}

#[test]
fn fuzz_reports_what_it_has_found_when_the_bus_does_not_come_back() {
    for (faults, status) in [(&[FAULT][..], 1), (&[], 3)] {
        let bench = Bench::new(faults);
        let (report, reproducers) = (bench.path("report.json"), bench.path("found"));
        let written = format!("json={report}");
        let more = ["--reconnect-timeout", "700ms", "--report", &written, "--reproducers", &reproducers];
        let fuzz = bench.start_fuzz(&more);
        bench.proxy.cut();
        let fuzzed = ended(fuzz);
        assert_eq!(fuzzed.status, status, "{}", fuzzed.stderr);
        let report = json(&fuzzed);
        let written: Value =
            serde_json::from_str(&std::fs::read_to_string(bench.path("report.json")).unwrap()).unwrap();
        assert_eq!(written, report);
        let why = report["ended_by"].as_str().unwrap();
        assert!(why.contains("was disconnected; the bus was not back within 7"), "{why}");
        assert_eq!((&report["interruptions"]["over"], &report["left"]), (&false.into(), &Value::Null), "{report:#}");
        let violations = report["violations"].as_array().unwrap().len();
        assert_eq!(violations, usize::from(status == 1), "{report:#}");
        // Each violation has a log and a test for pytest.
        assert_eq!(std::fs::read_dir(&reproducers).unwrap().count(), 2 * violations);
    }
}

/// Two reports can't be written because the disk is full: the other reports are written, and so are the reproducers.
#[cfg(target_os = "linux")]
#[test]
fn what_fuzz_has_found_is_kept_though_the_disk_is_full() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (page, regressions, found) = (format!("html={}", path("page.html")), path("regressions.log"), path("found"));
    let args = ["fuzz", "sim:reference-301+sdo-toggle-unchecked", "--seed", "1", "--runs", "200", "--stop-at-first"];
    let kept =
        ["--regressions", &regressions, "--reproducers", &found, "--report", "json=/dev/full", "--report", &page];
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let fuzz = command(&[&args[..], &kept].concat()).stdin(Stdio::null()).stdout(full).stderr(Stdio::piped()).spawn();
    let fuzzed = ended(fuzz.unwrap());
    assert_eq!(fuzzed.status, 2, "{}", fuzzed.stderr);
    assert!(fuzzed.stderr.contains("No space left"), "{}", fuzzed.stderr);
    assert!(std::fs::read_to_string(path("page.html")).unwrap().contains("PROP-02"));
    assert!(std::fs::read_to_string(&regressions).unwrap().contains("PROP-02"));
    // A log and a test for pytest.
    assert_eq!(std::fs::read_dir(&found).unwrap().count(), 2);
}

/// The fuzzer is the adapter; the simulated device is the client that reconnects.
#[test]
fn fuzz_waits_for_its_client_to_come_back() {
    let address = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let proxy = Proxy::start(address).unwrap();
    let args =
        ["fuzz", &format!("slcan:listen://{address}"), "--node", "10", "--device", "reference-301", "--for", "15s"];
    let fuzz = command(&[&args[..], &["--target", "sdo", "--format", "json"]].concat())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let listens = || std::net::TcpStream::connect(address).is_ok();
    proxy.wait("the fuzzer listens", listens);
    let mut device = command(&["simulate", "reference-301", &proxy.bus()]).stderr(Stdio::null()).spawn().unwrap();
    proxy.wait_for_lines(200);
    proxy.cut_for(Duration::from_millis(1_200));
    proxy.wait_for_lines(200);
    let fuzzed = ended(fuzz);
    device.kill().unwrap();
    device.wait().unwrap();
    let report = json(&fuzzed);
    assert_eq!((fuzzed.status, &report["violations"]), (0, &Value::Array(Vec::new())), "{report:#}");
    assert!(report["interruptions"]["count"].as_u64().unwrap() >= 1, "{report:#}");
}

/// Selects cases. The first two find the fault; the others run after them.
const CASES: [&str; 2] = ["--select", "301/sdo/download/second-toggle,301/sdo/download/segment-toggle,301/sdo/upload"];

impl Bench {
    /// Starts the cases, and waits until the first two are over: each begins with a reset, and ends with at most one
    /// more reset.
    fn start_test(&self, more: &[&str]) -> Child {
        let args = ["test", "BUS", "--node", "10", "--device", "reference-301", "--format", "json"];
        let child = self.start(&[&args[..], &CASES, more].concat());
        self.proxy.wait("the fault has shown", || self.proxy.has_sent("t0002810A", 6));
        child
    }
}

fn verdicts(report: &Value) -> Vec<&str> {
    report["cases"].as_array().unwrap().iter().map(|case| case["verdict"].as_str().unwrap()).collect()
}

#[test]
fn test_judges_what_comes_before_and_after() {
    for_each_span(&[FAULT], |bench, span| {
        let journal = bench.path("run.journal");
        assert_eq!(run(&["sdo", "write", &bench.device.bus, "10", "1017", "1000"]).status, 0);
        let test = bench.start_test(&["--journal", &journal]);
        bench.proxy.cut_for(span);
        let tested = ended(test);
        let report = json(&tested);
        assert_eq!(tested.status, 1, "{}", tested.stderr);
        let verdicts = verdicts(&report);
        assert_eq!(verdicts[..2], ["fail", "fail"], "what was found before is there: {verdicts:?}");
        let errors = verdicts.iter().filter(|verdict| **verdict == "error").count();
        assert!((1..=2).contains(&errors), "those under way: {verdicts:?}");
        assert_eq!(report["summary"]["error"], errors);
        let first = verdicts.iter().position(|verdict| *verdict == "error").unwrap();
        assert!(verdicts[first..].contains(&"pass"), "it goes on afterwards: {verdicts:?}");
        assert_eq!(report["host"]["interruptions"], 1);
        let lasted = Duration::from_nanos(report["host"]["interrupted_ns"].as_u64().unwrap());
        assert!(lasted + Duration::from_millis(50) >= span, "{span:?}: {lasted:?}");
        // Unstored values are as before, and no journal is left.
        let read = run(&["sdo", "read", &bench.device.bus, "10", "1017"]);
        assert!(read.stdout.contains("= 1000"), "{}{}", read.stdout, read.stderr);
        assert!(!Path::new(&journal).exists());
    });
}

#[test]
fn test_ends_with_its_report_when_the_bus_does_not_come_back() {
    let bench = Bench::new(&[FAULT]);
    let test = bench.start_test(&["--journal", "none", "--timeout", "reconnect=700ms"]);
    bench.proxy.cut();
    let tested = ended(test);
    let report = json(&tested);
    assert_eq!(tested.status, 1, "{}", tested.stderr);
    let verdicts = verdicts(&report);
    assert_eq!(verdicts[..2], ["fail", "fail"], "{verdicts:?}");
    let first = verdicts.iter().position(|verdict| *verdict == "error").unwrap();
    assert!(verdicts.len() > first + 3, "{verdicts:?}");
    assert!(
        verdicts[first..].iter().all(|verdict| *verdict == "error"),
        "the device fails for nothing else: {verdicts:?}"
    );
    let last = report["cases"].as_array().unwrap().last().unwrap();
    assert!(last["reason"]["actual"].as_str().unwrap().contains("was not back within"), "{last:#}");
}

/// The times of node 10's heartbeats in a candump log, in seconds.
fn heartbeats(log: &str) -> Vec<f64> {
    let lines = log.lines().filter(|line| line.contains("70A#"));
    lines.map(|line| line.trim_start_matches('(').split(')').next().unwrap().parse().unwrap()).collect()
}

/// The SLCAN line that sets the heartbeat time of node 10 to 50 ms.
const HEARTBEAT: &str = "t60A82B17100032000000";

#[test]
fn record_goes_on() {
    for_each_span(&[], |bench, span| {
        let log = bench.path("bus.log");
        let record = bench.start(&["record", "BUS", &log]);
        let has_heartbeats = |count| move |log: &str| heartbeats(log).len() >= count;
        let wait = |what: &str, is_so: &dyn Fn(&str) -> bool| {
            bench.proxy.wait(what, || std::fs::read_to_string(&log).is_ok_and(|log| is_so(&log)));
        };
        bench.proxy.wait_for_lines(4);
        bench.proxy.inject(HEARTBEAT).unwrap();
        wait("heartbeats are recorded", &has_heartbeats(5));
        bench.proxy.cut_for(span);
        let before = heartbeats(&std::fs::read_to_string(&log).unwrap()).len();
        wait("and again", &has_heartbeats(before + 10));
        assert!(interrupt(&record));
        let recorded = ended(record);
        assert_eq!(recorded.status, 0, "{}", recorded.stderr);
        assert!(recorded.stderr.contains("recording goes on when the bus is back"), "{}", recorded.stderr);
        assert!(recorded.stderr.contains(" 0 lost, 1 interruption of the bus, for "), "{}", recorded.stderr);
        let times = heartbeats(&std::fs::read_to_string(&log).unwrap());
        let gap = times.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        assert!(gap + 0.1 >= span.as_secs_f64(), "{gap} s: {times:?}");
    });
}

#[test]
fn record_and_monitor_end_with_status_3_when_the_bus_does_not_come_back() {
    for (name, more) in [("record", &["LOG"][..]), ("monitor", &["--format", "json"])] {
        let bench = Bench::new(&[]);
        let log = bench.path("bus.log");
        let more: Vec<&str> = more.iter().map(|arg| if *arg == "LOG" { &*log } else { arg }).collect();
        let child = bench.start(&[&[name, "BUS"][..], &more].concat());
        bench.proxy.wait_for_lines(4);
        bench.proxy.inject(HEARTBEAT).unwrap();
        std::thread::sleep(Duration::from_millis(700));
        bench.proxy.cut();
        std::thread::sleep(Duration::from_millis(500));
        assert!(interrupt(&child));
        let listened = ended(child);
        assert_eq!(listened.status, 3, "{name}: {}", listened.stderr);
        assert!(listened.stderr.contains("1 interruption of the bus, for "), "{name}: {}", listened.stderr);
        assert!(listened.stderr.contains(" so far ("), "{name}: {}", listened.stderr);
        let recorded = std::fs::read_to_string(&log).map(|log| heartbeats(&log).len()).unwrap_or_default();
        let shown = listened.stdout.matches("\"heartbeat\"").count();
        assert!(recorded + shown > 3, "what came before is there: {name}, {}", listened.stdout);
    }
}

#[test]
fn scan_asks_again_what_was_interrupted() {
    let bench = Bench::new(&[]);
    let whole = run(&["scan", &bench.device.bus, "--format", "json"]);
    let scan = bench.start(&["scan", "BUS", "--format", "json"]);
    bench.proxy.wait("the nodes are asked", || bench.proxy.has_sent("t60A840", 2));
    bench.proxy.cut_for(Duration::from_millis(1_200));
    let scanned = ended(scan);
    assert_eq!((scanned.status, &scanned.stdout), (0, &whole.stdout), "{}", scanned.stderr);
    assert!(scanned.stderr.contains("1 interruption of the bus, for "), "{}", scanned.stderr);
}

#[test]
fn scan_prints_what_it_has_found_when_the_bus_does_not_come_back() {
    let bench = Bench::new(&[]);
    let scan = bench.start(&["scan", "BUS", "--format", "json", "--reconnect-timeout", "500ms"]);
    bench.proxy.wait("the node is asked", || bench.proxy.has_sent("t60A840", 2));
    bench.proxy.cut();
    let scanned = ended(scan);
    let found = json(&scanned);
    assert_eq!((scanned.status, &found["complete"]), (3, &false.into()), "{}", scanned.stderr);
    assert_eq!(found["nodes"][0]["node"], 10, "{found:#}");
    assert!(scanned.stderr.contains("the scan was not completed"), "{}", scanned.stderr);
}

const AREA: [&str; 2] = ["--range", "1000-20FF"];

#[test]
fn from_device_asks_again_what_was_interrupted() {
    let bench = Bench::new(&[]);
    let whole = run(&[&["eds", "from-device", &bench.device.bus, "--node", "10"][..], &AREA].concat());
    let read = bench.start(&[&["eds", "from-device", "BUS", "--node", "10"][..], &AREA].concat());
    bench.proxy.wait_for_lines(60);
    bench.proxy.cut_for(Duration::from_millis(1_200));
    let read = ended(read);
    assert_eq!((whole.status, read.status), (0, 0), "{}", read.stderr);
    // The two descriptions were made at different times, and the type of the device's clock is guessed from its value.
    let undated = |text: &str| -> Vec<String> {
        let sections = text.split("\n[").filter(|section| !section.starts_with("2020]"));
        let lines = sections.flat_map(str::lines);
        lines.filter(|line| !line.contains("Time=") && !line.contains("Date=")).map(str::to_owned).collect()
    };
    assert!(whole.stdout.contains("[1018sub1]"), "{}", whole.stdout);
    assert_eq!(undated(&read.stdout), undated(&whole.stdout), "{}", read.stderr);
}

#[test]
fn from_device_writes_what_it_has_read_when_the_bus_does_not_come_back() {
    let bench = Bench::new(&[]);
    let file = bench.path("device.eds");
    let args = ["eds", "from-device", "BUS", "--node", "10", "-o", &file, "--reconnect-timeout", "500ms"];
    let read = bench.start(&[&args[..], &AREA].concat());
    bench.proxy.wait("the identity is read", || bench.proxy.has_sent("t60A8401810", 5));
    bench.proxy.wait_for_lines(20);
    bench.proxy.cut();
    let read = ended(read);
    assert_eq!(read.status, 3, "{}", read.stderr);
    assert!(
        read.stderr.contains(" on nothing was read: the description holds the objects read until then"),
        "{}",
        read.stderr
    );
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("[1018sub1]") && text.contains("Description=Read from a device, in part: "), "{text}");
    let checked = run(&["eds", "check", &file]);
    assert_eq!(checked.status, 0, "{}", checked.stdout);
}
