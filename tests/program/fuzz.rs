//! `canvass fuzz` as a user runs it.

use crate::live::Device;
use crate::running::{Run, run};
use serde_json::Value;

const HEALTHY: &str = "sim:reference-301";
const FAULTY: &str = "sim:reference-301+sdo-toggle-unchecked";

fn json(run: &Run) -> Value {
    serde_json::from_str(&run.stdout).unwrap_or_else(|error| panic!("{error}: {}{}", run.stdout, run.stderr))
}

#[test]
fn the_same_seed_is_the_same_run_byte_for_byte() {
    for format in ["table", "json", "junit", "html", "markdown"] {
        let once = || run(&["fuzz", FAULTY, "--seed", "11", "--runs", "60", "--format", format]);
        let (first, second) = (once(), once());
        assert_eq!(first.status, 1, "{}", first.stderr);
        assert_eq!(first.stdout, second.stdout, "{format}");
    }
    let other = run(&["fuzz", FAULTY, "--seed", "12", "--runs", "60", "--format", "json"]);
    let same = run(&["fuzz", FAULTY, "--seed", "11", "--runs", "60", "--format", "json"]);
    assert_ne!(json(&other)["executions"], json(&same)["executions"]);
}

#[test]
fn a_healthy_device_violates_nothing() {
    let fuzzed = run(&["fuzz", HEALTHY, "--seed", "1", "--runs", "900", "--format", "json"]);
    let report = json(&fuzzed);
    assert_eq!((fuzzed.status, &report["violations"]), (0, &Value::Array(Vec::new())), "{report:#}");
    assert_eq!((&report["schema"], &report["seed"]), (&"canvass/fuzz/1".into(), &1.into()));
    assert!(report["executions"].as_u64().unwrap() > 1_000, "{report:#}");
    let sdo = &report["coverage"]["sdo"];
    assert!(sdo["reached"].as_u64().unwrap() > 50 && sdo["reachable"].as_u64().unwrap() > 100, "{sdo:#}");
}

#[test]
fn several_services_are_fuzzed_together() {
    let fuzzed = |target: &str, seed: &str| {
        json(&run(&["fuzz", FAULTY, "--target", target, "--seed", seed, "--runs", "60", "--format", "json"]))
    };
    let report = fuzzed("pdo,sdo", "3");
    assert_eq!(report["target"], "sdo,pdo");
    assert!(report["repeat"].as_str().unwrap().contains("--target sdo,pdo "), "{report:#}");
    let properties = |report: &serde_json::Value| -> Vec<String> {
        let violations = report["violations"].as_array().unwrap();
        violations.iter().map(|violation| violation["property"].as_str().unwrap().to_owned()).collect()
    };
    assert!(properties(&report).iter().any(|property| property == "PROP-02"), "{report:#}");
    // A fault of the SDO server does not show in requests to other services.
    let report = fuzzed("nmt,sync-emcy", "3");
    assert_eq!((&report["target"], properties(&report)), (&"nmt,sync-emcy".into(), Vec::new()), "{report:#}");
}

#[test]
fn a_violation_is_handed_over_to_be_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (regressions, page) = (file("regressions.log"), format!("html={}", file("fuzz.html")));
    let args =
        ["fuzz", FAULTY, "--target", "sdo", "--seed", "3", "--runs", "400", "--stop-at-first", "--format", "json"];
    let fuzzed = run(&[&args[..], &["--regressions", &regressions, "--report", &page]].concat());
    let report = json(&fuzzed);
    assert_eq!(fuzzed.status, 1, "{report:#}");
    let violation = &report["violations"][0];
    assert_eq!((&violation["property"], &violation["confirmed"]), (&"PROP-02".into(), &true.into()), "{violation:#}");
    let frames = violation["frames"].as_array().unwrap();
    assert!((1..=8).contains(&frames.len()), "{violation:#}");
    assert!(frames.iter().all(|frame| frame["id"].is_u64() && frame["text"].is_string()), "{violation:#}");
    assert!(violation["test"].as_str().unwrap().contains("#[test]"));
    assert!(std::fs::read_to_string(file("fuzz.html")).unwrap().contains("PROP-02"));

    // The log alone reproduces the violation, on this device and not on a healthy one.
    let log = file("violation.log");
    std::fs::write(&log, violation["log"].as_str().unwrap()).unwrap();
    let replayed = run(&["fuzz", FAULTY, "--replay", &log, "--format", "json"]);
    assert_eq!((replayed.status, &json(&replayed)["violations"][0]["rule"]), (1, &violation["rule"]));
    assert_eq!(run(&["fuzz", HEALTHY, "--replay", &log]).status, 0);
    assert_eq!(run(&["decode", &log]).status, 0, "it is a capture as any other");

    // The next run tries the recorded sequence first, and does not append it again.
    let noted = std::fs::read_to_string(&regressions).unwrap();
    assert!(noted.starts_with("# canvass fuzz: PROP-02"), "{noted}");
    let again = ["fuzz", FAULTY, "--seed", "99", "--runs", "1", "--format", "json", "--regressions", &regressions];
    let next = json(&run(&again));
    assert_eq!(next["violations"][0]["rule"], violation["rule"], "{next:#}");
    assert_eq!(std::fs::read_to_string(&regressions).unwrap(), noted);
}

#[test]
fn what_is_not_allowed_is_not_sent() {
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("store.log");
    std::fs::write(&log, "(1.000000) can0 60A#2310100173617665\n").unwrap();
    let log = log.to_str().unwrap();
    let refused = run(&["fuzz", HEALTHY, "--replay", log]);
    assert_eq!((refused.status, refused.stderr.contains("--allow nvm")), (2, true), "{}", refused.stderr);
    let allowed = run(&["fuzz", HEALTHY, "--replay", log, "--allow", "nvm"]);
    assert_eq!(allowed.status, 0, "{}{}", allowed.stdout, allowed.stderr);
}

#[test]
fn mistakes_have_their_status() {
    for (args, status, says) in [
        (&["fuzz", "sim:no-such-model"][..], 2, "kuebler-sendix-58x8"),
        (&["fuzz", HEALTHY, "--target", "nonsense"], 2, "sync-emcy"),
        (&["fuzz", HEALTHY, "--for", "soon"], 2, "10"),
        (&["fuzz", HEALTHY, "--replay", "/no/such/file"], 2, "can't read"),
        (&["fuzz", HEALTHY, "--report", "html=/no/such/folder/x.html"], 2, "can't write"),
        (&["fuzz", "sim:reference-301+reference-406"], 2, "one simulated device"),
        (&["fuzz", "slcan:/dev/no-such-port", "--node", "5"], 3, "/dev/no-such-port"),
    ] {
        let ended = run(args);
        assert_eq!(ended.status, status, "{args:?}: {}", ended.stderr);
        assert!(ended.stderr.contains(says), "{args:?}: {}", ended.stderr);
    }
}

#[test]
fn properties_are_listed_and_explained() {
    let listed = run(&["list", "properties", "--format", "json"]);
    let listed: Value = serde_json::from_str(&listed.stdout).unwrap();
    let ids: Vec<&str> = listed.as_array().unwrap().iter().map(|row| row["id"].as_str().unwrap()).collect();
    assert_eq!((ids.len(), ids[0], ids[16]), (17, "PROP-01", "PROP-17"));
    for id in ids {
        assert!(run(&["explain", id]).stdout.starts_with(id));
    }
    assert!(run(&["explain", "PROP-05"]).stdout.contains("abort"));
}

/// Each violation gets files that reproduce it: a log, and a test for pytest with the same frames.
#[test]
fn reproducers_are_files_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let kept = folder.path().join("found/here");
    let bus = "sim:reference-301+sdo-toggle-unchecked";
    let path = kept.display().to_string();
    let fuzzed = run(&[
        "fuzz",
        bus,
        "--runs",
        "300",
        "--seed",
        "1",
        "--stop-at-first",
        "--reproducers",
        &path,
        "--format",
        "json",
    ]);
    assert_eq!(fuzzed.status, 1, "{}", fuzzed.stderr);
    let mut files: Vec<_> = std::fs::read_dir(&kept).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "log"));
    let result: serde_json::Value = serde_json::from_str(&fuzzed.stdout).unwrap();
    assert_eq!(files.len(), result["violations"].as_array().unwrap().len(), "{files:?}");
    let file = files[0].display().to_string();
    assert!(file.contains("prop-") && file.ends_with("-seed1.log"), "{file}");
    let again = run(&["fuzz", bus, "--replay", &file]);
    assert_eq!(again.status, 1, "{}{}", again.stdout, again.stderr);
    let violation = &result["violations"][0];
    let test = format!("test_{}_seed1.py", violation["id"].as_str().unwrap().replace('-', "_"));
    assert_eq!(std::fs::read_to_string(kept.join(test)).unwrap(), violation["pytest"].as_str().unwrap());
    let log = std::fs::read_to_string(&files[0]).unwrap();
    for seen in violation["evidence"].as_array().unwrap() {
        assert!(log.contains(seen["data"].as_str().unwrap()), "the log has the frames of both sides: {log}");
    }
    let repetitions = violation["repetitions"].as_array().unwrap();
    assert!(repetitions.len() >= 3 && repetitions.iter().all(|one| one["shows"] == true), "{repetitions:?}");
}

#[test]
fn all_can_be_allowed_at_once() {
    let all = ["--select", "301/store", "--dry-run", "--format", "json"];
    let would_run = |allow: &str| {
        let planned = run(&[&["test", "sim:kuebler-sendix-58x8", "--allow", allow], &all[..]].concat());
        assert_eq!(planned.status, 0, "{}", planned.stderr);
        serde_json::from_str::<serde_json::Value>(&planned.stdout).unwrap()["would_run"].as_u64().unwrap()
    };
    let named = would_run("nvm,node-id,bit-rate,other-nodes,factory-defaults,preset");
    assert_eq!(would_run("all"), named);
    assert!(named > would_run("node-id"), "some of them need leave");
}

/// The position was 19642 steps. The preset makes it 19949 and is stored, so that a reset does not restore the old zero
/// point.
#[test]
fn a_zero_point_that_a_sequence_has_moved_is_told_with_how_to_set_it_right() {
    let device = Device::of("kuebler-sendix-58x8", &[]);
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("preset.log");
    std::fs::write(&log, "(0.000000) can0 63F#23036000ED4D0000\n(0.100000) can0 63F#2310100173617665\n").unwrap();
    let replay = log.to_str().unwrap();
    let fuzz = |more: &[&str]| {
        let args = ["fuzz", &*device.bus, "--node", "63", "--device", "kuebler-sendix-58x8", "--replay", replay];
        run(&[&args[..], more].concat())
    };
    let told = json(&fuzz(&["--allow", "preset,nvm", "--format", "json"]));
    assert_eq!(told["zero_point"]["steps"], 307, "{told:#}");
    let text = told["zero_point"]["text"].as_str().unwrap();
    assert!(text.contains("give 6003h:00 that value minus 307"), "{text}");
    std::fs::write(&log, "(0.000000) can0 63F#4000100000000000\n").unwrap();
    assert_eq!(json(&fuzz(&["--format", "json"]))["zero_point"], Value::Null);
}

/// A corpus is kept between runs: the next run begins with what the last has reached, and with what showed violations.
#[test]
fn a_corpus_is_kept_between_runs() {
    let folder = tempfile::tempdir().unwrap();
    let corpus = folder.path().join("corpus").display().to_string();
    let fuzz = |bus: &str, seed: &str, runs: &str| {
        run(&["fuzz", bus, "--seed", seed, "--runs", runs, "--corpus-dir", &corpus, "--format", "json"])
    };
    let reached = |run: &Run| json(run)["coverage"]["sdo"]["reached"].as_u64().unwrap();
    let first = fuzz(HEALTHY, "1", "200");
    assert_eq!(first.status, 0, "{}", first.stderr);
    let files = || std::fs::read_dir(&corpus).unwrap().count();
    let kept = files();
    assert!(kept > 10, "{kept}");
    // As many sequences as the corpus has reach as much as the whole first run.
    let again = fuzz(HEALTHY, "2", &kept.to_string());
    assert!(reached(&again) >= reached(&first), "{} of {}", reached(&again), reached(&first));
    assert!(files() <= kept, "{} of {kept}", files());
    let broken = fuzz(FAULTY, "3", "400");
    assert_eq!(broken.status, 1, "{}", broken.stderr);
    assert!(std::path::Path::new(&corpus).join("regressions.log").exists());
    // The first sequence is the one that showed the violation.
    assert_eq!(json(&fuzz(FAULTY, "4", "1"))["violations"][0]["rule"], json(&broken)["violations"][0]["rule"]);
}
