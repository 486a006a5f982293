//! A run that Ctrl-C ends: its report is written, and the device is as it was.

use crate::running::{command, finished, interrupt};
use serde_json::Value;
use std::process::Stdio;

const ENCODER: &str = "sim:kuebler-sendix-58x8";

fn document(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// A run that would take long is ended after its first case: its report holds that case, and the run is no good one.
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

/// Whether a case is marked as one that passed in a recording in that folder, which need not have its name yet.
fn has_passed_one(folder: &std::path::Path) -> bool {
    let files = std::fs::read_dir(folder).unwrap().flatten();
    let texts = files.filter_map(|file| std::fs::read(file.path()).ok());
    texts.into_iter().any(|text| String::from_utf8_lossy(&text).contains(" ends: pass"))
}

/// A device that was at work, with values that nobody has stored, has them again after a run that was interrupted.
#[test]
fn an_interrupted_run_leaves_the_dictionary_as_it_was() {
    for round in 0..20_u64 {
        let child = command(&["test", "sim:reference-301", "--allow", "nvm", "--format", "json"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Any moment, but the same ones in every run of this test.
        std::thread::sleep(std::time::Duration::from_millis(round * 37 % 400));
        assert!(interrupt(&child));
        let ended = finished(child.wait_with_output().unwrap());
        if ended.stdout.is_empty() {
            continue;
        }
        let report = document(&ended.stdout);
        assert_eq!(report["notices"], Value::Array(Vec::new()), "round {round}: {}", report["notices"]);
        // Interrupted while the dictionary was read, no case has run.
        let ran = !report["cases"].as_array().unwrap().is_empty();
        assert!(!ran || report["dictionary"].as_array().unwrap().len() > 100);
    }
}
