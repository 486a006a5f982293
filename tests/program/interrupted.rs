//! Ctrl-C ends a run: the report is written, and the device is left as it was.

use crate::running::{command, finished, interrupt};
use serde_json::Value;
use std::process::Stdio;

const ENCODER: &str = "sim:kuebler-sendix-58x8";

fn document(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// A long run is ended after its first case: the report holds this case, and the exit status is no success.
#[test]
fn ctrl_c_still_writes_the_report() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("run.log").display().to_string();
    let args = ["test", ENCODER, "--select", "301/sdo", "--format", "json", "--repeat", "100", "--record", &recording];
    let mut child = command(&args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begun = std::time::Instant::now();
    while !has_passed_one(folder.path()) {
        assert_eq!(child.try_wait().unwrap(), None, "the run ended by itself");
        assert!(begun.elapsed().as_secs() < 60, "no case has ended");
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    assert!(interrupt(&child));
    let ended = finished(child.wait_with_output().unwrap());
    assert_eq!(ended.status, 1, "{}", ended.stderr);
    let report = document(&ended.stdout);
    assert_eq!((&report["schema"], &report["cancelled"]), (&"canvass/test/1".into(), &true.into()));
    let verdicts: Vec<&Value> = report["cases"].as_array().unwrap().iter().map(|case| &case["verdict"]).collect();
    assert!(verdicts.contains(&&"pass".into()), "{verdicts:?}");
}

/// Whether a recording in this folder marks a case as passed; the recording need not have its final name yet.
fn has_passed_one(folder: &std::path::Path) -> bool {
    let files = std::fs::read_dir(folder).unwrap().flatten();
    let texts = files.filter_map(|file| std::fs::read(file.path()).ok());
    texts.into_iter().any(|text| String::from_utf8_lossy(&text).contains(" ends: pass"))
}

/// An interrupted run restores the unstored values that the device had before.
#[test]
fn an_interrupted_run_leaves_the_dictionary_as_it_was() {
    for round in 0..20_u64 {
        let child = command(&["test", "sim:reference-301", "--allow", "nvm", "--format", "json"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // The moments are arbitrary, but the same in every run of this test.
        std::thread::sleep(std::time::Duration::from_millis(round * 37 % 400));
        assert!(interrupt(&child));
        let ended = finished(child.wait_with_output().unwrap());
        if ended.stdout.is_empty() {
            continue;
        }
        let report = document(&ended.stdout);
        assert_eq!(report["notices"], Value::Array(Vec::new()), "round {round}: {}", report["notices"]);
        // If the run was interrupted while the dictionary was read, no case has run.
        let ran = !report["cases"].as_array().unwrap().is_empty();
        assert!(!ran || report["dictionary"].as_array().unwrap().len() > 100);
    }
}
