//! `canvass diagnose`, and the simulated devices in normal operation.

use crate::running::{run, run_with_input};
use canvass_analyzer::Index;
use canvass_analyzer::findings::{Diagnosis, SourceQuality, Thresholds};
use canvass_bus::Bus;
use canvass_device::models::Model;
use canvass_traces::{Duration, Quality, Record, Timestamp, parse_frame};
use serde_json::Value;

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

/// A master that looks for nodes sends requests to all node-IDs: absent nodes get no row each.
#[test]
fn who_was_only_asked_is_told_in_one_line() {
    let asked = |nodes: std::ops::Range<u16>| -> String {
        let request = |node| format!("(1700000000.3{node:05}) can0 {:03X}#4000100000000000\n", 0x600 + node);
        nodes.map(request).collect()
    };
    let scanned = run_with_input(&["diagnose", "-"], &format!("{HEALTHY}{}", asked(1..128))).stdout;
    assert!(scanned.contains("never sent anything, but somebody addressed them: 1 to 4, 6 to 127\n"), "{scanned}");
    let rows = |text: &str| text.lines().filter(|line| line.starts_with("│ ")).count();
    assert_eq!(rows(&run_with_input(&["diagnose", "-"], HEALTHY).stdout), rows(&scanned));
    let few = run_with_input(&["diagnose", "-"], &format!("{HEALTHY}{}", asked(1..3))).stdout;
    assert!(few.contains("│ 1 ") && !few.contains("somebody addressed"), "{few}");
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

/// Control sequences in a device name do not act on the terminal.
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
    // The old content is gone, however long it was.
    std::fs::write(&page, "x".repeat(1_000_000)).unwrap();
    let date = ["--date", "2026-11-22"];
    let made = run(&[&["diagnose", capture_text, "--format", "html", "--force", "-o", page_text], &date[..]].concat());
    assert_eq!((made.status, made.stdout.as_str()), (1, ""), "{}", made.stderr);
    let written = std::fs::read_to_string(&page).unwrap();
    assert!(written.starts_with("<!DOCTYPE html>") && written.ends_with("</html>\n"));
    assert!(!written.contains("http-equiv=\"refresh\"") && !written.contains("src=") && !written.contains("@import"));
    // The program refuses to overwrite the capture, under any spelling of its path.
    for path in [capture_text.to_owned(), format!("{}/./restart.log", folder.path().display())] {
        let refused = run(&["diagnose", capture_text, "--format", "json", "--output", &path]);
        let told = ["restart.log is read", "can't be written"].iter().all(|words| refused.stderr.contains(words));
        assert!(refused.status == 2 && told, "{}", refused.stderr);
    }
    assert_eq!(std::fs::read_to_string(&capture).unwrap(), RESTART);
    let refused = run(&["diagnose", capture_text, "--output", "/no/such/folder/page.html"]);
    assert!(refused.status == 2 && refused.stdout.is_empty(), "{}", refused.stderr);
    let to_stdout = run(&[&["diagnose", capture_text, "--format", "html", "-o", "-"], &date[..]].concat());
    assert_eq!(to_stdout.stdout, written);
}

/// `--node` and `--channel` choose what is told; the exit status is that of what is told.
#[test]
fn nodes_and_channels_are_chosen() {
    let two = format!("{RESTART}{}", RESTART.replace("can0 705", "can1 706").replace("can0 085", "can1 086"));
    let nodes = |args: &[&str]| {
        let (status, told) = json(&[&["diagnose", "-", "--format", "json"], args].concat(), &two);
        let nodes = told["findings"].as_array().unwrap().iter().filter_map(|finding| finding["node"].as_u64());
        (status, nodes.collect::<std::collections::BTreeSet<u64>>())
    };
    assert_eq!(nodes(&[]), (1, [5, 6].into()));
    assert_eq!(nodes(&["--node", "6"]), (1, [6].into()));
    assert_eq!(nodes(&["--channel", "can0"]), (1, [5].into()));
    assert_eq!(nodes(&["--node", "1..4,7"]), (0, [].into()));
    let misspelt = run_with_input(&["diagnose", "-", "--channel", "can7"], &two);
    assert!(misspelt.stderr.contains("no channel is named can7; there were: can0, can1"), "{}", misspelt.stderr);
}

/// One run writes every format, each as it would be on standard output.
#[test]
fn reports_go_to_files_beside_standard_output() {
    let folder = tempfile::tempdir().unwrap();
    let capture = folder.path().join("a.log").display().to_string();
    std::fs::write(&capture, RESTART).unwrap();
    let at = |format: &str| folder.path().join(format).display().to_string();
    let reports: Vec<String> = ["json", "junit", "markdown", "html"]
        .iter()
        .map(|format| format!("--report={format}={}", at(format)))
        .collect();
    let date = ["--date", "2026-01-02T03:04:05Z"];
    let together =
        [&["diagnose", &capture], &date[..], &reports.iter().map(String::as_str).collect::<Vec<_>>()].concat();
    let told = run(&together);
    assert_eq!(told.status, 1, "{}", told.stderr);
    assert_eq!(told.stdout, run(&[&["diagnose", &capture], &date[..]].concat()).stdout);
    for format in ["json", "junit", "markdown", "html"] {
        let alone = run(&[&["diagnose", &capture, "--format", format], &date[..]].concat()).stdout;
        assert_eq!(std::fs::read_to_string(at(format)).unwrap(), alone, "{format}");
    }
    let refused = |args: &[&str]| {
        let run = run(&[&["diagnose", &capture], args].concat());
        (run.status, run.stderr)
    };
    let onto_itself = format!("json={capture}");
    for (args, reason) in [
        (&["--report", "svg=a.svg"][..], "expected table, json, markdown, junit or html, found \"svg\""),
        (&["--report", &onto_itself], "is read and can't be written at the same time"),
        (&["--report", "html=-", "--report", "html=a.html"], "the page is written once"),
        (&["--format", "json", "--report", "markdown=-"], "standard output takes one report"),
    ] {
        let (status, error) = refused(args);
        assert!(status == 2 && error.contains(reason), "{args:?}: {status} {error}");
    }
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
        // Devices of DS-301 V3.0 have neither of the two objects.
        let has = |index| model.description().dictionary.object(Index(index)).is_some();
        if has(0x1018) {
            self.sdo("4018100100000000");
        }
        if has(0x1017) {
            self.sdo("2B17100064000000");
        }
        self.send(&format!("000#01{:02X}", self.node));
    }

    /// Half a minute with SYNC and an SDO client that reads the position, or 1000h if the device has no position.
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
            diagnosis.describe(
                model.default_node().unwrap(),
                canvass_analyzer::dictionary::KnownDevice::clone(model.device()),
            );
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

/// The kernel has delivered two frames in the wrong order: `decode` sorts them on request, `diagnose` always.
#[test]
fn records_out_of_order() {
    let log = "(1.000) can0 702#00\n(2.009) can0 602#4017100000000000\n(2.004) can0 703#05\n(3.000) can0 702#7F\n";
    let ids = |args: &[&str]| {
        let lines = run_with_input(&[&["decode", "-", "--format", "json"], args].concat(), log).stdout;
        let id = |line: &str| serde_json::from_str::<Value>(line).unwrap()["id"].as_u64().unwrap();
        lines.lines().map(id).collect::<Vec<_>>()
    };
    assert_eq!(ids(&[]), [0x702, 0x602, 0x703, 0x702]);
    assert_eq!(ids(&["--in-order"]), [0x702, 0x703, 0x602, 0x702]);
    let (_, document) = json(&["diagnose", "-", "--format", "json"], log);
    let found = document["findings"].as_array().unwrap();
    assert!(found.iter().any(|finding| finding["rule"] == "capture/out-of-order"), "{document}");
}

/// If a capture holds the bit rate, the program infers none; the user's bit rate takes precedence.
#[test]
fn the_bit_rate_of_a_capture() {
    let log = "ASCII Trace IXXAT MiniMon V3  Version: 1.1.4.4533\nDate: 28.01.2025\nStart time: 10:47:15\n\
        Baudrate: 125 kbit/s\n\"10:47:15.23\";\"705\";\"Std\";\"\";\"05 \"\n\"10:47:16.23\";\"705\";\"Std\";\"\";\"05 \"\n";
    let run = run_with_input(&["diagnose", "-"], log);
    assert!(run.stdout.contains("125 kbit/s") && !run.stdout.contains("inferred"), "{}", run.stdout);
    let run = run_with_input(&["diagnose", "-", "--bit-rate", "250k"], log);
    assert!(run.stdout.contains("250 kbit/s"), "{}", run.stdout);
}

#[test]
fn a_story_begins_with_what_must_be_known() {
    let mut log = String::new();
    for n in 0..20 {
        log.push_str(&format!("({}.0) can0 701#05\n", 1_000 + n));
        if n < 8 {
            log.push_str(&format!("({}.1) can0 705#05\n", 1_000 + n));
        }
    }
    log.push_str("(1020.0) can0 705#00\n");
    let table = run_with_input(&["diagnose", "-"], &log).stdout;
    let first = table.lines().next().unwrap();
    assert!(first.contains("node 5") && first.contains("nodes/lost"), "{table}");
    assert!(table.contains("then at 20.000000 s: node 5: boot-up without a reset command"), "{table}");
    let (_, document) = json(&["diagnose", "-", "--format", "json"], &log);
    let story = &document["stories"][0];
    let rule = |at: &Value| document["findings"][at.as_u64().unwrap() as usize]["rule"].clone();
    assert_eq!(rule(&story["findings"][0]), "nodes/lost");
    assert_eq!(rule(&story["consequences"][0]["findings"][0]), "nodes/boot-up-without-command");
    assert_eq!(story["consequences"][0]["of"], story["findings"][0]);
    let markdown = run_with_input(&["diagnose", "-", "--format", "markdown"], &log).stdout;
    assert!(markdown.contains("This follows from: node 5: a node drops out"), "{markdown}");
    let page = run_with_input(&["diagnose", "-", "--format", "html"], &log).stdout;
    assert!(page.contains("follows from"), "no story in the page");
}

/// However many findings there are, the table fits on a page; `--verbose` shows all.
#[test]
fn a_noisy_capture_takes_fewer_than_sixty_lines() {
    let mut log = String::new();
    for n in 0..4_000_u64 {
        let (time, node) = (1_000 + n / 20, 2 + n % 19);
        let micros = n % 20 * 50_000;
        let frame = match n % 5 {
            0 => format!("{:03X}#{:02X}503F0000000000", 0x80 + node, n % 7),
            1 => format!("{:03X}#00", 0x700 + node),
            2 => format!("{:03X}#8000{:02X}0002000106", 0x580 + node, n % 97),
            3 => format!("{:03X}#4000100000000000", 0x600 + node),
            _ => "000#81".to_owned(),
        };
        log.push_str(&format!("({time}.{micros:06}) can0 {frame}\n"));
    }
    let table = run_with_input(&["diagnose", "-"], &log).stdout;
    assert!(table.lines().count() < 60, "{} lines:\n{table}", table.lines().count());
    let verbose = run_with_input(&["diagnose", "-", "--verbose"], &log).stdout;
    assert!(verbose.lines().count() > 300, "{} lines", verbose.lines().count());
}

/// Loading a faulty description prints one line that names the command to show all problems.
#[test]
fn problems_of_a_description_are_told_when_it_is_loaded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motor.eds");
    let text = "[FileInfo]\nFileName=x.eds\n[DeviceInfo]\nVendorName=x\nVendorNumber=abc\n[1000]\n\
        ParameterName=Device type\nObjectType=0x7\nDataType=0x0007\nAccessType=sometimes\nDefaultValue=12z\n";
    std::fs::write(&path, text).unwrap();
    let device = format!("5={}", path.display());
    for command in ["decode", "diagnose"] {
        let run = run_with_input(&[command, "-", "--device", &device], HEALTHY);
        let told: Vec<_> = run.stderr.lines().filter(|line| line.contains("motor.eds")).collect();
        assert_eq!((run.status, told.len()), (0, 1), "{}", run.stderr);
        assert!(told[0].contains("the first: line ") && told[0].contains(" errors, "), "{}", told[0]);
        assert!(told[0].ends_with(&format!("(`canvass eds check {}` shows all)", path.display())), "{}", told[0]);
    }
    let all = run(&["eds", "check", path.to_str().unwrap()]);
    assert_eq!(all.status, 1, "{}", all.stderr);
    for line in ["VendorNumber=abc", "AccessType=sometimes", "DefaultValue=12z"] {
        assert!(all.stdout.lines().any(|shown| shown.ends_with(&format!(" | {line}"))), "{}", all.stdout);
    }
}

/// A file that is half unreadable, or has both sides of a merge in it, describes no device.
#[test]
fn a_device_file_that_is_none_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("motor.eds");
    std::fs::write(&path, "[DeviceInfo]\n<<<<<<< HEAD\nVendorName=a\n=======\nVendorName=b\n>>>>>>> other\n").unwrap();
    let device = format!("5={}", path.display());
    for command in ["decode", "diagnose"] {
        let refused = run_with_input(&[command, "-", "--device", &device], HEALTHY);
        assert!(
            refused.status == 2 && refused.stderr.contains("line 2 begins an unresolved merge conflict"),
            "{}",
            refused.stderr
        );
    }
}
