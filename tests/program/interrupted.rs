//! A run that Ctrl-C ends: its report is written, and the device is as it was.

use crate::running::{command, finished, interrupt};
use serde_json::Value;
use std::process::Stdio;

const ENCODER: &str = "sim:kuebler-sendix-58x8";

fn document(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

#[test]
fn ctrl_c_still_writes_the_report() {
    // So many repetitions of the catalogue never end by themselves in the time of this test: the signal ends them.
    let child =
        command(&["test", ENCODER, "--format", "json"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let interrupted = interrupt(&child);
    let ended = finished(child.wait_with_output().unwrap());
    // The run may be over before the signal comes, or not have begun; what it must not be is killed half-way.
    assert!(interrupted);
    assert!(ended.status < 0 || [0, 1, 3].contains(&ended.status), "{}", ended.status);
    if ended.status >= 0 && ended.status != 3 {
        assert_eq!(document(&ended.stdout)["schema"], "canvass/test/1");
    }
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
