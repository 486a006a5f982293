//! A run as one file: every changed byte is detected, and the verdicts follow from the recording.

use crate::archive;
use crate::live::Device;
use crate::running::run;
use serde_json::{Value, json};
use std::path::Path;

const FAULTY: &str = "sim:kuebler-sendix-58x8+boot-up-twice";

/// A bundle of a run; returns its path and the run's status.
fn bundled(folder: &Path, args: &[&str]) -> (String, i32) {
    let path = folder.join("run.zip").display().to_string();
    let tested = run(&[&["test"], args, &["--bundle", &path, "--force"]].concat());
    assert!([0, 1].contains(&tested.status), "{}", tested.stderr);
    (path, tested.status)
}

fn unzipped(path: &str) -> Vec<(String, Vec<u8>)> {
    archive::files(&std::fs::read(path).unwrap())
}

#[test]
fn all_verdicts_of_a_bundle_follow_from_its_recording() {
    let folder = tempfile::tempdir().unwrap();
    let waivers = folder.path().join("waivers.toml").display().to_string();
    let text =
        "[[waiver]]\ncase = \"301/boot-up/reset-node\"\nobject = \"boot-up\"\ndoes = \"count 2\"\nreason = \"x\"\n";
    std::fs::write(&waivers, text).unwrap();
    for args in [
        &[
            FAULTY,
            "--select",
            "301/boot-up,301/heartbeat,305",
            "--waivers",
            &waivers,
            "--allow",
            "nvm,node-id,bit-rate",
        ][..],
        &["sim:reference-301", "--select", "301/sdo,301/store,301/tpdo", "--allow", "nvm", "--seed", "5"],
        &["sim:kuebler-sendix-m58", "--node", "9", "--select", "301/identity,301/emcy", "--retries", "1"],
    ] {
        let (path, _) = bundled(folder.path(), args);
        let verified = run(&["verify", &path]);
        assert_eq!(verified.status, 0, "{args:?}: {}{}", verified.stdout, verified.stderr);
        assert!(verified.stdout.contains("verdicts follow from the recording"), "{}", verified.stdout);
    }
}

/// In real time the tester's clock is independent of the frames; the transcript holds its values.
#[test]
fn a_run_on_a_live_bus_is_judged_again_without_it() {
    let folder = tempfile::tempdir().unwrap();
    let device = Device::of("reference-301", &["--fault", "boot-up-twice"]);
    let select = ["--node", "10", "--device", "reference-301", "--select", "301/boot-up/reset-node,301/identity"];
    let (path, status) = bundled(folder.path(), &[&[device.bus.as_str(), "--journal", "none"], &select[..]].concat());
    assert_eq!(status, 1);
    // The device is not available for the verification.
    drop(device);
    let verified = run(&["verify", &path, "--format", "json"]);
    assert_eq!(verified.status, 0, "{}{}", verified.stdout, verified.stderr);
    let report: Value = serde_json::from_str(&verified.stdout).unwrap();
    assert!(report["cases"].as_u64().is_some_and(|cases| cases >= 5), "{report}");
    // The verification needs the times of the transcript: without them it fails.
    let mut files = unzipped(&path);
    let transcript = String::from_utf8(files[4].1.clone()).unwrap();
    assert!(transcript.contains("live yes") && transcript.contains("\ntime "), "{transcript}");
    files[4].1 = transcript
        .lines()
        .filter(|line| !line.starts_with("frames"))
        .flat_map(|l| [l, "\n"])
        .collect::<String>()
        .into();
    forge(&path, &mut files);
    assert_ne!(run(&["verify", &path]).status, 0);
}

#[test]
fn a_bundle_is_an_archive_with_a_manifest_and_is_reproducible() {
    let folder = tempfile::tempdir().unwrap();
    let (path, status) = bundled(folder.path(), &[FAULTY, "--select", "301/boot-up"]);
    assert_eq!(status, 1, "the run's own status");
    let first = std::fs::read(&path).unwrap();
    let files = unzipped(&path);
    let names: Vec<&str> = files.iter().map(|file| file.0.as_str()).collect();
    let expected = ["manifest.json", "result.json", "report.html", "recording.pcapng", "transcript.txt", "run.json"];
    assert_eq!(names, expected);
    let manifest: Value = serde_json::from_slice(&files[0].1).unwrap();
    assert_eq!(manifest["files"][2]["sha256"], archive::sha256(&files[3].1));
    let recording = folder.path().join("recording.pcapng").display().to_string();
    std::fs::write(&recording, &files[3].1).unwrap();
    assert!(run(&["decode", &recording]).stdout.contains("boot-up"));
    assert_eq!(run(&["test", FAULTY, "--bundle", &path]).status, 2, "what is there is not overwritten unasked");
    bundled(folder.path(), &[FAULTY, "--select", "301/boot-up"]);
    assert!(first == std::fs::read(&path).unwrap(), "two runs differ");
}

#[test]
fn one_changed_byte_is_refused_naming_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = bundled(folder.path(), &[FAULTY, "--select", "301/boot-up/reset-node"]);
    let whole = std::fs::read(&path).unwrap();
    let files = unzipped(&path);
    let place = |content: &[u8]| whole.windows(content.len()).position(|window| window == content).unwrap();
    for (name, content) in &files {
        let mut other = whole.clone();
        other[place(content) + content.len() / 2] ^= 1;
        std::fs::write(&path, &other).unwrap();
        let refused = run(&["verify", &path]);
        assert_eq!(refused.status, 1, "{name}: {}", refused.stderr);
        // If the manifest was changed, the program can't tell whether the manifest or the file was.
        assert!(
            refused.stderr.contains("changed") || refused.stderr.contains("manifest"),
            "{name}: {}",
            refused.stderr
        );
        assert!(name == "manifest.json" || refused.stderr.contains(name), "{name}: {}", refused.stderr);
    }
    // Changes bytes all over the archive, and several bytes of its directory.
    let directory = whole.len() - 600..whole.len();
    for at in (0..whole.len()).step_by(whole.len() / 40).chain(directory.step_by(37)) {
        let mut other = whole.clone();
        other[at] ^= 0x10;
        std::fs::write(&path, &other).unwrap();
        assert_ne!(run(&["verify", &path]).status, 0, "byte {at}");
    }
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    assert_eq!(run(&["verify", &path]).status, 1);
    assert_eq!(run(&["verify", "Cargo.toml"]).status, 2);
    assert_eq!(run(&["verify", "/no/such.zip"]).status, 2);
}

/// A forger of a verdict can make the hashes fit, but the verdict contradicts the recording.
#[test]
fn a_forged_verdict_does_not_follow_from_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let case = "301/boot-up/reset-node";
    let (path, _) = bundled(folder.path(), &[FAULTY, "--select", case]);
    let mut files = unzipped(&path);
    let mut result: Value = serde_json::from_slice(&files[1].1).unwrap();
    assert_eq!(result["cases"][0]["verdict"], "fail");
    result["cases"][0]["verdict"] = json!("pass");
    files[1].1 = serde_json::to_vec_pretty(&result).unwrap();
    forge(&path, &mut files);
    let verified = run(&["verify", &path, "--format", "json"]);
    assert_eq!(verified.status, 1, "{}{}", verified.stdout, verified.stderr);
    let report: Value = serde_json::from_str(&verified.stdout).unwrap();
    assert_eq!((&report["unchanged"], &report["divergence"]), (&true.into(), &Value::Null));
    assert_eq!(report["differences"], json!([{ "case": case, "result": "pass", "recording": "fail" }]));
    // A verdict also contradicts a recording from which its cause was cut.
    let transcript = String::from_utf8(files[4].1.clone()).unwrap();
    files[4].1 = transcript.replace("bit-rate 250000", "bit-rate 250000\nbegin 5").into_bytes();
    let half = files[3].1.len() / 2;
    files[3].1.truncate(half);
    forge(&path, &mut files);
    assert_ne!(run(&["verify", &path]).status, 0);
}

/// Packs the files with a manifest that matches them.
fn forge(path: &str, files: &mut [(String, Vec<u8>)]) {
    let mut manifest: Value = serde_json::from_slice(&files[0].1).unwrap();
    for (row, (_, content)) in manifest["files"].as_array_mut().unwrap().iter_mut().zip(&files[1..]) {
        row["bytes"] = content.len().into();
        row["sha256"] = archive::sha256(content).into();
    }
    let manifest = format!("{manifest:#}\n").into_bytes();
    files[0].1 = manifest;
    std::fs::write(path, archive::pack(files)).unwrap();
}
