//! Reports are evidence: each contains its provenance, and the report of a simulated run is the same whenever it is
//! made.

use crate::archive;
use crate::running::{command, finished, run};
use serde_json::Value;

const ENCODER: &str = "sim:kuebler-sendix-58x8";
const FORMATS: [&str; 5] = ["table", "json", "junit", "html", "markdown"];
/// The SHA-256 of `abc`, from `printf abc | sha256sum`.
const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn path(folder: &tempfile::TempDir, name: &str) -> String {
    folder.path().join(name).display().to_string()
}

/// Runs a command with a report in each format, and returns the contents of the reports.
fn reported(folder: &tempfile::TempDir, args: &[&str]) -> Vec<String> {
    let files: Vec<String> = FORMATS.iter().map(|format| path(folder, &format!("report.{format}"))).collect();
    let reports: Vec<String> = FORMATS.iter().zip(&files).map(|(format, file)| format!("{format}={file}")).collect();
    let mut args = args.to_vec();
    args.extend(reports.iter().flat_map(|report| ["--report", report]));
    let ended = run(&args);
    assert_eq!(ended.status, 0, "{}", ended.stderr);
    files.iter().map(|file| std::fs::read_to_string(file).unwrap()).collect()
}

#[test]
fn every_format_of_test_tells_where_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let recording = path(&folder, "run.log");
    let args = ["test", ENCODER, "--select", "301/identity", "--note", "tester=Ann", "--note", "firmware=1.4.2"];
    let more = ["--date", "2026-11-22T14:00:00+01:00", "--record", &recording, "--tolerance", "7"];
    let reports = reported(&folder, &[&args[..], &more[..]].concat());
    let hash = archive::sha256(&std::fs::read(&recording).unwrap());
    let told = [
        env!("CARGO_PKG_VERSION"),
        "2026-11-22T14:00:00+01:00",
        "250",
        "simulated",
        "Kuebler Sendix Encoder",
        "tolerance",
        "exhaustive",
        "sdo=1s",
        "Ann",
        "1.4.2",
        &hash,
    ];
    for (report, format) in reports.iter().zip(FORMATS) {
        for told in told {
            assert!(report.contains(told), "{format} lacks {told}");
        }
    }
    let provenance = &json(&reports[1])["provenance"];
    let option = |name: &str| {
        let options = provenance["options"].as_array().unwrap();
        options.iter().find(|option| option["name"] == name).unwrap().clone()
    };
    assert_eq!((&option("tolerance")["value"][0], &option("tolerance")["default"][0]), (&"7".into(), &"5".into()));
    assert_eq!((&option("exhaustive")["value"][0], &option("exhaustive")["by"]), (&"no".into(), &"default".into()));
    assert_eq!((&option("node")["value"][0], &provenance["devices"][0]["vendor_id"]), (&"63".into(), &19.into()));
    assert_eq!(provenance["notes"]["tester"], "Ann");
}

#[test]
fn files_are_told_with_their_hash() {
    let folder = tempfile::tempdir().unwrap();
    let waivers = path(&folder, "w.toml");
    std::fs::write(&waivers, "").unwrap();
    let tested = run(&["test", ENCODER, "--select", "301/identity", "--waivers", &waivers, "--format", "json"]);
    let file = &json(&tested.stdout)["provenance"]["files"][0];
    // The SHA-256 of an empty file.
    let empty = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";
    assert_eq!((&file["role"], &file["sha256"], &file["bytes"]), (&"waivers".into(), &empty.into(), &0.into()));
    let capture = path(&folder, "abc.log");
    std::fs::write(&capture, "abc").unwrap();
    let diagnosed = run(&["diagnose", &capture, "--format-in", "candump", "--format", "json"]);
    assert_eq!(json(&diagnosed.stdout)["provenance"]["files"][0]["sha256"], ABC, "{}", diagnosed.stderr);
}

/// Two runs have the same reports, wherever these are written; with a given date, only the date differs.
#[test]
fn simulated_runs_are_the_same_to_the_byte() {
    let folder = tempfile::tempdir().unwrap();
    let once = |name: &str, epoch: &str| {
        let file = path(&folder, name);
        let args = ["test", ENCODER, "--select", "301/heartbeat", "--report", &format!("json={file}")];
        let ended = finished(command(&args).env("SOURCE_DATE_EPOCH", epoch).output().unwrap());
        assert_eq!(ended.status, 0, "{}", ended.stderr);
        std::fs::read_to_string(file).unwrap()
    };
    let (first, second, other) = (once("a", "1800000000"), once("b", "1800000000"), once("c", ""));
    assert_eq!(first, second);
    assert_eq!(json(&first)["provenance"]["date"], "2027-01-15T08:00:00+00:00");
    assert_eq!(
        (&json(&other)["provenance"]["date"], &json(&other)["provenance"]["host"]),
        (&Value::Null, &Value::Null)
    );
    let wrong = command(&["test", ENCODER]).env("SOURCE_DATE_EPOCH", "today").output().unwrap();
    assert_eq!(finished(wrong).status, 2);
}

#[test]
fn every_format_of_fuzz_tells_where_it_comes_from() {
    let folder = tempfile::tempdir().unwrap();
    let args =
        ["fuzz", "sim:reference-301", "--seed", "1", "--runs", "3", "--note", "tester=Ann", "--date", "2026-11-22"];
    for (report, format) in reported(&folder, &args).iter().zip(FORMATS) {
        for told in ["2026-11-22T00:00:00+00:00", "canvass reference 301", "shrink-budget", "2000", "Ann", "simulated"]
        {
            assert!(report.contains(told), "{format} lacks {told}");
        }
    }
}

#[test]
fn every_format_of_diagnose_tells_where_it_comes_from() {
    for format in FORMATS {
        let args = ["diagnose", "docs/examples/commissioning.log", "--note", "tester=Ann", "--format", format];
        let ended = run(&[&args[..], &["--date", "2026-11-22T14:00:00+01:00", "--fail-on", "never", "-v"]].concat());
        assert_eq!(ended.status, 0, "{}", ended.stderr);
        let hash = "6890c873f37837d88fe1df424b3c773cc366a36439d388c6d82b296f8badbc63";
        for told in ["2026-11-22T14:00:00+01:00", hash, "Ann", "fail-on", "Kuebler", std::env::consts::OS] {
            assert!(ended.stdout.contains(told), "{format} lacks {told}");
        }
    }
}

#[test]
fn a_comparison_tells_what_it_compared() {
    let folder = tempfile::tempdir().unwrap();
    let result = path(&folder, "result.json");
    run(&["test", ENCODER, "--select", "301/identity", "--report", &format!("json={result}")]);
    let compared = run(&["compare", &result, &result, "--format", "json", "--note", "release=7"]);
    let provenance = &json(&compared.stdout)["provenance"];
    assert_eq!(provenance["files"].as_array().unwrap().len(), 2);
    assert_eq!(provenance["devices"][1]["name"], "Kuebler Sendix Encoder");
    assert!(provenance["date"].is_string() && provenance["host"]["name"].is_string());
    let text = run(&["compare", &result, &result, "--note", "release=7"]).stdout;
    assert!(text.contains("note release 7") && text.contains("SHA-256"), "{text}");
}

#[test]
fn what_can_not_be_evidence_is_refused() {
    for (args, says) in [
        (&["test", "vcan9", "--node", "1", "--date", "2026-11-22"][..], "the clock"),
        (&["test", ENCODER, "--date", "yesterday"], "expected a date"),
        (&["test", ENCODER, "--note", "tester"], "KEY=VALUE"),
        (&["test", ENCODER, "--note", "a=1", "--note", "a=2"], "twice"),
    ] {
        let ended = run(args);
        assert_eq!(ended.status, 2, "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(says), "{args:?}: {}", ended.stderr);
    }
}

/// The exit status tells the verdict whatever happens to standard output, in every format.
#[test]
fn nobody_reading_changes_no_verdict() {
    for format in FORMATS {
        for (args, status) in [
            (&["diagnose", "docs/examples/commissioning.log", "--format", format][..], 1),
            (&["fuzz", "sim:reference-301", "--runs", "2", "--seed", "1", "--format", format], 0),
            (&["test", "sim:reference-301+boot-up-twice", "--select", "301/boot-up", "--format", format], 1),
        ] {
            let (reader, writer) = std::io::pipe().unwrap();
            drop(reader);
            let ended = command(args).stdout(writer).stderr(std::process::Stdio::null()).status().unwrap();
            assert_eq!(ended.code(), Some(status), "{args:?}");
        }
    }
}
