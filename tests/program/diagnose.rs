//! `canvass diagnose`, and the simulated devices in normal operation.

use crate::running::{run, run_with_input};
use canvass_analyzer::Index;
use canvass_analyzer::findings::{Diagnosis, SourceQuality, Thresholds};
use canvass_bus::Bus;
use canvass_device::models::Model;
use canvass_reports::diagnosis::handbook;
use canvass_traces::{Duration, Quality, Record, Timestamp, parse_frame};
use serde_json::Value;
use std::path::Path;

/// A node that restarts by itself, after an error.
const RESTART: &str = "\
(1700000000.000000) can0 705#05
(1700000000.100000) can0 705#05
(1700000000.200000) can0 705#05
(1700000000.250000) can0 085#1081110000000000
(1700000000.900000) can0 705#00
";

const HEALTHY: &str = "\
(1700000000.000123) can0 705#05
(1700000000.100123) can0 705#05
(1700000000.200123) can0 705#05
";

fn json(args: &[&str], input: &str) -> (i32, Value) {
    let run = run_with_input(args, input);
    (run.status, serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}", run.stderr)))
}

#[test]
fn the_contract_of_json() {
    let (status, document) = json(&["diagnose", "-", "--format", "json"], RESTART);
    assert_eq!(status, 1);
    assert_eq!(document["schema"], "canvass/diagnose/1");
    assert_eq!((&document["frames"], &document["counts"]["heartbeat"]), (&5.into(), &3.into()));
    assert_eq!((&document["counts"]["boot-up"], &document["counts"]["emcy"]), (&1.into(), &1.into()));
    let findings = document["findings"].as_array().unwrap();
    let rules: Vec<_> = findings.iter().map(|finding| finding["rule"].as_str().unwrap()).collect();
    assert!(rules.contains(&"emcy/raised") && rules.contains(&"nodes/boot-up-without-command"), "{rules:?}");
    let restart = findings.iter().find(|finding| finding["rule"] == "nodes/boot-up-without-command").unwrap();
    assert_eq!((&restart["node"], &restart["severity"]), (&5.into(), &"warning".into()));
    assert_eq!(restart["t"], 1_700_000_000_900_000_000_u64);
    let evidence = restart["evidence"].as_array().unwrap();
    let last = evidence.last().unwrap();
    assert_eq!((&last["number"], &last["id"], &last["data"]), (&5.into(), &0x705.into(), &"00".into()));
    assert_eq!(document["nodes"][0]["boot_ups"], 1);
    assert_eq!(document["quality"]["schema"], "canvass/quality/1");
}

#[test]
fn the_status_says_how_bad_it_is() {
    let status = |args: &[&str], input| run_with_input(&[&["diagnose", "-"], args].concat(), input).status;
    assert_eq!(status(&[], HEALTHY), 0);
    assert_eq!(status(&[], RESTART), 1);
    assert_eq!(status(&["--fail-on", "never"], RESTART), 0);
    let warning = RESTART.replace("(1700000000.250000) can0 085#1081110000000000\n", "");
    assert_eq!(status(&[], &warning), 0);
    assert_eq!(status(&["--fail-on", "warning"], &warning), 1);
    assert_eq!(status(&["--threshold", "bus/load.percentage=1"], HEALTHY), 2);
    assert_eq!(run(&["diagnose", "no-such-file.log"]).status, 2);
}

#[test]
fn every_format_names_the_frames() {
    for format in ["table", "markdown", "junit", "json", "html"] {
        let run = run_with_input(&["diagnose", "-", "--format", format], RESTART);
        assert!(run.stdout.contains("8110h"), "{format}: {}", run.stdout);
        assert!(run.stdout.contains("without a reset command"), "{format}: {}", run.stdout);
    }
    let junit = run_with_input(&["diagnose", "-", "--format", "junit"], HEALTHY).stdout;
    assert!(junit.contains("failures=\"0\"") && junit.contains("heartbeat-missing"), "{junit}");
}

/// What a device calls itself is no command to the terminal.
#[test]
fn hostile_names_are_shown_and_do_nothing() {
    let read = "(1.0) c\x1b[31mn 605#4008100000000000\n(1.1) c\x1b[31mn 585#430810001B5B324A\n";
    for format in ["table", "markdown", "junit", "json", "html"] {
        let run = run_with_input(&["diagnose", "-", "--format", format], read);
        assert!(!run.stdout.contains('\x1b') && !run.stderr.contains("\x1b[2J"), "{format}: {}", run.stdout);
    }
}

#[test]
fn the_result_goes_to_a_file() {
    let folder = tempfile::tempdir().unwrap();
    let (capture, page) = (folder.path().join("restart.log"), folder.path().join("page.html"));
    let [capture_text, page_text] = [&capture, &page].map(|path| path.to_str().unwrap());
    std::fs::write(&capture, RESTART).unwrap();
    // What it held before is gone, however long it was.
    std::fs::write(&page, "x".repeat(1_000_000)).unwrap();
    let made = run(&["diagnose", capture_text, "--format", "html", "-o", page_text]);
    assert_eq!((made.status, made.stdout.as_str()), (1, ""), "{}", made.stderr);
    let written = std::fs::read_to_string(&page).unwrap();
    assert!(written.starts_with("<!DOCTYPE html>") && written.ends_with("</html>\n"));
    assert!(!written.contains("http-equiv=\"refresh\"") && !written.contains("src=") && !written.contains("@import"));
    // The capture is not lost to a slip, whatever it is called.
    for path in [capture_text.to_owned(), format!("{}/./restart.log", folder.path().display())] {
        let refused = run(&["diagnose", capture_text, "--format", "json", "--output", &path]);
        assert!(refused.status == 2 && refused.stderr.contains("is read and can't be written"), "{}", refused.stderr);
    }
    assert_eq!(std::fs::read_to_string(&capture).unwrap(), RESTART);
    let refused = run(&["diagnose", capture_text, "--output", "/no/such/folder/page.html"]);
    assert!(refused.status == 2 && refused.stdout.is_empty(), "{}", refused.stderr);
    let to_stdout = run(&["diagnose", capture_text, "--format", "html", "-o", "-"]);
    assert_eq!(to_stdout.stdout, written);
}

#[test]
fn rules_are_listed_and_explained() {
    let (_, rules) = json(&["list", "rules", "--format", "json"], "");
    let rules = rules.as_array().unwrap();
    assert!(rules.len() > 40, "{}", rules.len());
    for rule in rules {
        let explained = run(&["explain", rule["id"].as_str().unwrap()]);
        assert!(explained.status == 0 && explained.stdout.contains("What to do:"), "{rule}: {}", explained.stderr);
    }
}

/// `UPDATE_DOCS=1 cargo test rules_md` renews the file.
#[test]
fn rules_md_is_current() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/rules.md");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, handbook()).unwrap();
    }
    let written = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(written == handbook(), "docs/rules.md is out of date: UPDATE_DOCS=1 cargo test rules_md renews it");
}

/// A master that starts a simulated device and works with it.
struct Operation {
    bus: Box<dyn Bus>,
    node: u8,
    seen: Vec<Record>,
}

impl Operation {
    fn of(model: &Model) -> Self {
        let node = model.default_node().expect("a node-ID").raw();
        let bus = canvass_device::address::open(&format!("sim:{}", model.id())).unwrap().bus;
        Self { bus, node, seen: Vec::new() }
    }

    fn wait(&mut self, ms: u64) {
        let deadline = self.bus.now() + Duration::from_millis(ms);
        while let Some(record) = self.bus.receive(deadline).unwrap() {
            self.seen.push(record);
        }
    }

    fn send(&mut self, frame: &str) {
        self.bus.send(&parse_frame(frame).unwrap().frame).unwrap();
    }

    fn sdo(&mut self, request: &str) {
        self.send(&format!("{:03X}#{request}", 0x600 + u16::from(self.node)));
        self.wait(50);
    }

    fn start(&mut self, model: &Model) {
        self.wait(1500);
        self.sdo("4000100000000000");
        // DS-301 V3.0 had neither of the two.
        let has = |index| model.description().dictionary.object(Index(index)).is_some();
        if has(0x1018) {
            self.sdo("4018100100000000");
        }
        if has(0x1017) {
            self.sdo("2B17100064000000");
        }
        self.send(&format!("000#01{:02X}", self.node));
    }

    /// Half a minute with SYNC and an SDO client that reads the position, or what else the device has.
    fn run(&mut self, model: &Model) {
        let encoder = model.description().dictionary.object(Index(0x6004)).is_some();
        let request = if encoder { "4004600000000000" } else { "4000100000000000" };
        for _ in 0..300 {
            self.send("080#");
            self.wait(40);
            self.sdo(request);
            self.wait(10);
        }
    }

    fn findings(&self, model: &Model, described: bool) -> Vec<String> {
        let mut diagnosis = Diagnosis::new(Thresholds::default());
        if described {
            diagnosis.describe(model.default_node().unwrap(), model.description().clone());
        }
        let mut quality = Quality::default();
        for record in &self.seen {
            let mut record = record.clone();
            record.timestamp = Timestamp(record.timestamp.nanos() + 1_700_000_000_000_000_000);
            quality.record(&record);
            diagnosis.record(&record);
        }
        let results = diagnosis.finish(&[SourceQuality { name: "simulated", quality: &quality }]);
        results.findings.iter().map(|finding| format!("{}: {}", finding.rule.id, finding.message)).collect()
    }
}

#[test]
fn simulated_devices_in_normal_operation_have_no_findings() {
    for model in Model::all().iter().filter(|model| model.default_node().is_some()) {
        let mut operation = Operation::of(model);
        operation.start(model);
        operation.run(model);
        assert!(operation.seen.len() > 1000, "{}", operation.seen.len());
        for described in [false, true] {
            let findings = operation.findings(model, described);
            assert!(findings.is_empty(), "{}, described: {described}: {findings:#?}", model.id());
        }
    }
}
