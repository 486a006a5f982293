//! `canvass test` and `canvass send` as a user meets them.

use crate::running::{command, finished, run};
use serde_json::Value;
use std::process::Stdio;

const ENCODER: &str = "sim:kuebler-sendix-58x8";

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn the_simulated_encoder_passes() {
    let tested = run(&["test", ENCODER, "--format", "json"]);
    assert_eq!(tested.status, 0, "{}", tested.stderr);
    let report = json(&tested.stdout);
    assert_eq!(report["schema"], "canvass/test/1");
    let cases = report["cases"].as_array().unwrap();
    assert!(cases.len() >= 12);
    for case in cases {
        assert!(!case["clause_confidence"].as_str().unwrap().is_empty(), "{case}");
        assert_ne!(case["verdict"], "fail", "{case}");
        assert_ne!(case["verdict"], "error", "{case}");
    }
    assert!(report["summary"]["pass"].as_u64().unwrap() >= 12);
}

#[test]
fn two_runs_give_the_same_bytes() {
    let once = || run(&["test", ENCODER, "--format", "json", "--seed", "7"]).stdout;
    assert_eq!(once(), once());
}

#[test]
fn a_faulty_firmware_fails_with_reason_and_frames() {
    let address = format!("{ENCODER}+sdo-toggle-unchecked");
    let tested = run(&["test", &address, "--format", "json"]);
    assert_eq!(tested.status, 1);
    let report = json(&tested.stdout);
    let failed = report["cases"].as_array().unwrap().iter().find(|case| case["verdict"] == "fail").unwrap();
    for part in ["duty", "expected", "actual"] {
        assert!(!failed["reason"][part].as_str().unwrap().is_empty(), "{failed}");
    }
    let frame = &failed["evidence"][0];
    assert!(frame["t"].is_u64() && frame["id"].is_u64() && frame["data"].is_string() && frame["text"].is_string());
    let shown = run(&["test", &address]);
    assert!(shown.stdout.contains("expected") && shown.stdout.contains("63F#") || shown.stdout.contains("63F"));
}

#[test]
fn no_case_is_no_success() {
    let tested = run(&["test", ENCODER, "--select", "nonsense"]);
    assert_eq!(tested.status, 3);
    assert!(tested.stderr.contains("no case was executed"), "{}", tested.stderr);
}

#[test]
fn mistakes_have_their_status() {
    for (args, status, says) in [
        (&["test", "sim:no-such-model"][..], 2, "kuebler-sendix-58x8"),
        (&["test", "sim:kuebler-sendix-58x8+no-such-fault"], 2, "canvass list faults"),
        (&["test", "can0", "--node", "1"], 3, "SocketCAN"),
        (&["test", ENCODER, "--node", "5"], 3, "node 5 does not answer"),
        (&["test", ENCODER, "--report", "html=/no/such/folder/x.html"], 2, "can't write"),
        (&["send", ENCODER, "63F#4"], 2, "position"),
        (&["explain", "nonsense"], 2, "nothing is called"),
    ] {
        let ended = run(args);
        assert_eq!(ended.status, status, "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(says), "{args:?}: {}", ended.stderr);
    }
}

/// Writing and reading 6000h, as Kübler's manual prints it (5.3.7.4).
#[test]
fn send_shows_request_and_response() {
    let sent = run(&["send", ENCODER, "63F#2B00600001000000", "63F#4000600000000000"]);
    assert_eq!(sent.status, 0, "{}", sent.stderr);
    let lines: Vec<&str> = sent.stdout.lines().collect();
    assert_eq!(lines.len(), 4);
    for (line, frame) in lines.iter().zip([
        "63F  2B 00 60 00 01 00 00 00",
        "5BF  60 00 60 00 00 00 00 00",
        "63F  40 00 60 00 00 00 00 00",
        "5BF  4B 00 60 00 01 00 00 00",
    ]) {
        assert!(line.contains(frame), "{line}");
    }
    assert!(lines[3].contains("Operating parameters = 1"));
}

#[test]
fn what_there_is_can_be_listed_and_explained() {
    for what in ["cases", "models", "faults", "formats"] {
        let listed = json(&run(&["list", what, "--format", "json"]).stdout);
        let rows = listed.as_array().unwrap();
        assert!(!rows.is_empty());
        for row in rows {
            let id = row["id"].as_str().unwrap();
            assert!(!row["summary"].as_str().unwrap().is_empty(), "{id}");
            if what == "faults" {
                assert!(row["model"].is_string() && row["fuzz"].is_boolean(), "{id}");
            }
        }
        let id = rows[0]["id"].as_str().unwrap();
        assert!(run(&["explain", id]).stdout.starts_with(id));
    }
}

#[test]
fn all_reports_of_a_run_are_written() {
    let folder = env!("CARGO_TARGET_TMPDIR");
    let files: Vec<String> = ["html", "junit", "json", "markdown"]
        .iter()
        .map(|format| format!("{format}={folder}/report.{format}"))
        .collect();
    let mut args = vec!["test", ENCODER];
    args.extend(files.iter().flat_map(|file| ["--report", file]));
    assert_eq!(run(&args).status, 0);
    for file in files {
        let path = file.split_once('=').unwrap().1;
        assert!(std::fs::metadata(path).unwrap().len() > 1000, "{path}");
    }
}

#[test]
fn ctrl_c_still_writes_the_report() {
    // So many repetitions of the catalogue never end by themselves in the time of this test: the signal ends them.
    let child =
        command(&["test", ENCODER, "--format", "json"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let killed = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    let ended = finished(child.wait_with_output().unwrap());
    // The run may be over before the signal comes, or not have begun; what it must not be is killed half-way.
    assert!(killed.is_ok());
    assert!([0, 1, 3, -1].contains(&ended.status), "{}", ended.status);
    if ended.status >= 0 && ended.status != 3 {
        assert_eq!(json(&ended.stdout)["schema"], "canvass/test/1");
    }
}
