//! The cases of a run in its recording: their ids mark them, and the report refers to them.

use crate::running::run;
use serde_json::Value;

const BUS: &str = "sim:kuebler-sendix-58x8+boot-up-twice";
const CASE: &str = "301/boot-up/reset-node";

/// A run with a recording of this name: its result, the path of the recording, and its messages on standard error.
fn recorded(folder: &tempfile::TempDir, name: &str, more: &[&str]) -> (Value, String, String) {
    let path = folder.path().join(name).display().to_string();
    let args = ["test", BUS, "--select", "301/boot-up", "--format", "json", "--record", &path];
    let tested = run(&[&args, more].concat());
    assert_eq!(tested.status, 1, "{}", tested.stderr);
    (serde_json::from_str(&tested.stdout).unwrap(), path, tested.stderr)
}

fn decoded(path: &str, more: &[&str]) -> String {
    run(&[&["decode", path], more].concat()).stdout
}

#[test]
fn every_format_with_comments_names_the_cases() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.pcapng", "run.mcap", "run.log", "run.asc", "run.trc", "run.log.gz"] {
        let (_, path, _) = recorded(&folder, name, &[]);
        let text = decoded(&path, &[]);
        for mark in [format!("# case {CASE} begins\n"), format!("# case {CASE} ends: fail\n")] {
            assert_eq!(text.matches(&mark).count(), 1, "{name}: {mark}");
        }
        assert!(!text.contains(" 7FF "), "{name}");
        let table = decoded(&path, &["--format", "table"]);
        assert!(table.contains(&format!("# case {CASE} begins\n")), "{name}");
    }
    let (_, _, said) = recorded(&folder, "run.csv", &[]);
    assert!(said.contains("the capture can't hold comments"), "{said}");
}

/// Events appear below the mark of the case in which they occurred.
#[test]
fn events_have_the_marks_too() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path, _) = recorded(&folder, "run.pcapng", &[]);
    let text = decoded(&path, &["--events"]);
    let mark = format!("case {CASE} begins");
    assert_eq!(text.matches(&format!("# {mark}\n")).count(), 1, "{text}");
    let (_, rest) = text.split_once(&format!("# {mark}\n")).unwrap();
    assert!(rest.split("\n# ").next().unwrap().contains("boot-up, was initialisation"), "{rest}");
    let json = decoded(&path, &["--events", "--format", "json"]);
    let told: Vec<Value> = json.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let comments = told.iter().filter(|event| event["event"] == "comment").map(|event| event["text"].as_str().unwrap());
    assert!(comments.into_iter().any(|text| text.contains(&mark)), "{json}");
    let none = decoded(&path, &["--events", "--filter", "service=emcy"]);
    assert!(none.is_empty() && !decoded(&path, &["--events", "--filter", "service=boot-up"]).is_empty(), "{none}");
}

#[test]
fn programs_read_the_marks_too() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path, _) = recorded(&folder, "run.pcapng", &[]);
    let mark = format!("case {CASE} begins");
    assert!(decoded(&path, &["--format", "json"]).contains(&format!("{mark}\"}}")), "JSON");
    assert!(decoded(&path, &["--format", "csv"]).contains(&mark), "CSV");
    // A selected frame is preceded by the mark of its case, even if the mark is attached to a frame that is not
    // selected.
    let boots = decoded(&path, &["--filter", "service=boot-up"]);
    assert!(boots.contains(&format!("# {mark}\n")) && !boots.contains(" 000 "), "{boots}");
    // The marks are kept when the capture is converted.
    let log = folder.path().join("converted.log").display().to_string();
    assert_eq!(run(&["convert", &path, &log]).status, 0);
    assert!(decoded(&log, &[]).contains(&format!("# {mark}\n")));
}

#[test]
fn a_diagnosis_names_the_case_that_provoked_a_finding() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.pcapng").display().to_string();
    let case = "301/nmt/long-frame";
    run(&["test", "sim:kuebler-sendix-58x8", "--select", case, "--record", &path]);
    let found: Value = serde_json::from_str(&run(&["diagnose", &path, "--format", "json"]).stdout).unwrap();
    let findings = found["findings"].as_array().unwrap();
    assert!(findings.iter().any(|finding| finding["case"]["id"] == case), "{findings:#?}");
    assert_eq!(found["buses"][0]["test_run"][0]["id"], case);
    assert_eq!(found["buses"][0]["test_run"][0]["verdict"], "pass");
    let table = run(&["diagnose", &path]).stdout;
    assert!(table.contains(&format!("in case {case} of the test run")), "{table}");
}

#[test]
fn markers_of_cias_tool_come_only_when_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path, _) = recorded(&folder, "run.pcapng", &["--cct-markers"]);
    let text = decoded(&path, &[]);
    assert!(text.contains("CiA test tool: case 1 of group"), "{text}");
    let without = run(&["test", BUS, "--cct-markers"]);
    assert!(without.status == 2 && without.stderr.contains("--record"), "{}", without.stderr);
}

/// Frame number N of a report is frame number N of the recording, with or without marker frames of CiA's tool.
#[test]
fn reports_number_the_frames_of_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    for (name, more) in [("a.pcapng", &[][..]), ("b.log", &["--cct-markers"][..])] {
        let (result, path, _) = recorded(&folder, name, more);
        let frames: Vec<Value> =
            decoded(&path, &["--format", "json"]).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let cases = result["cases"].as_array().unwrap();
        let case = cases.iter().find(|case| case["id"] == CASE).unwrap();
        let evidence = case["evidence"].as_array().unwrap();
        assert!(!evidence.is_empty());
        for shown in evidence {
            let recorded = &frames[shown["number"].as_u64().unwrap() as usize - 1];
            assert_eq!((&shown["t"], &shown["data"]), (&recorded["t"], &recorded["data"]), "{name}");
        }
        assert_eq!(case["recorded"][0], evidence[0]["number"]);
    }
}

#[test]
fn the_page_shows_where_the_frames_of_a_case_are() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.log").display().to_string();
    let page = run(&["test", BUS, "--select", CASE, "--format", "html", "--record", &path]).stdout;
    assert!(page.contains(" of the recording") && page.contains("href=\"#frame-"), "numbers");
    assert!(page.contains("<svg class=\"strip\""), "timeline");
    let unrecorded = run(&["test", BUS, "--select", CASE, "--format", "html"]).stdout;
    assert!(!unrecorded.contains(" of the recording") && !unrecorded.contains("href=\"#frame-"));
}
