//! `canvass.toml` and `CANVASS_BUS`: settings that hold without options on the command line.

use crate::running::{Run, command, finished, run};
use serde_json::Value;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const SETTINGS: &str = r#"bus = "sim:kuebler-sendix-58x8"
node = 63

[timeouts]
sdo = "2s"

[thresholds]
"bus/load.percent" = 70
"#;

/// A folder with this file, and a folder below it.
fn project(text: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("canvass.toml"), text).unwrap();
    let below = folder.path().join("below");
    std::fs::create_dir(&below).unwrap();
    (folder, below)
}

fn run_in(folder: &Path, args: &[&str]) -> Run {
    finished(command(args).current_dir(folder).env_remove("CANVASS_BUS").output().unwrap())
}

fn document(ended: &Run) -> Value {
    serde_json::from_str(&ended.stdout).unwrap_or_else(|error| panic!("{error}: {}", ended.stderr))
}

const CASE: [&str; 4] = ["--select", "301/nmt/back-to-back", "--format", "json"];

#[test]
fn settings_are_found_from_folders_below() {
    let (_folder, below) = project(SETTINGS);
    let tested = run_in(&below, &[&["test"], &CASE[..]].concat());
    assert_eq!(tested.status, 0, "{}", tested.stderr);
    let result = document(&tested);
    assert_eq!((&result["bus"], &result["node"]), (&"sim:kuebler-sendix-58x8".into(), &63.into()));
    let options = result["provenance"]["options"].as_array().unwrap();
    let timeout = options.iter().find(|option| option["name"] == "timeout").unwrap();
    assert_eq!((&timeout["by"], &timeout["value"][0]), (&"settings".into(), &"sdo=2s".into()));
    let files = result["provenance"]["files"].as_array().unwrap();
    assert!(files.iter().any(|file| file["role"] == "settings" && file["sha256"].is_string()), "{files:?}");
}

#[test]
fn what_is_typed_has_precedence() {
    let (_folder, below) = project(SETTINGS);
    // The node of the file belongs to the file's bus; another bus has another device.
    let other = document(&run_in(&below, &[&["test", "sim:reference-301"], &CASE[..]].concat()));
    assert_eq!((&other["bus"], &other["node"]), (&"sim:reference-301".into(), &10.into()));
    // A typed timeout replaces only its own value of the file.
    let waits = document(&run_in(&below, &[&["test", "--timeout", "silence=300ms"], &CASE[..]].concat()));
    let options = waits["provenance"]["options"].as_array().unwrap();
    let timeout = options.iter().find(|option| option["name"] == "timeout").unwrap();
    let values = timeout["value"].as_array().unwrap();
    assert!(values.contains(&"sdo=2s".into()) && values.contains(&"silence=300ms".into()), "{values:?}");
    let shorter = document(&run_in(&below, &[&["test", "--timeout", "sdo=1500ms"], &CASE[..]].concat()));
    assert!(shorter.to_string().contains("sdo=1500ms"));
}

#[test]
fn the_environment_names_the_bus() {
    let folder = tempfile::tempdir().unwrap();
    let mut tested = command(&[&["test"], &CASE[..]].concat());
    let tested = finished(tested.current_dir(folder.path()).env("CANVASS_BUS", "sim:reference-301").output().unwrap());
    assert_eq!(document(&tested)["bus"], "sim:reference-301");
    let without = run_in(folder.path(), &["test"]);
    assert!(without.status == 2 && without.stderr.contains("<BUS>"), "{}", without.stderr);
}

#[test]
fn the_bus_can_be_left_out_before_other_arguments() {
    let (_folder, below) = project(SETTINGS);
    let right = |typed: &[&str], expected: &str| {
        let ended = run_in(&below, typed);
        assert!(ended.status == 0 && ended.stdout.contains(expected), "{typed:?}: {} {}", ended.stdout, ended.stderr);
    };
    right(&["sdo", "read", "63", "1018:01"], "13");
    right(&["sdo", "write", "63", "1017", "100"], "100");
    right(&["--color", "never", "nmt", "start", "63"], "start");
    right(&["send", "--wait", "10ms", "63F#4018100100000000", "000#0100"], "1018");
    right(&["lss", "inquire"], "63");
    // Another bus is typed as ever.
    right(&["sdo", "read", "sim:reference-301", "10", "1018:01"], "");
    let mut typed = command(&["nmt", "start", "10"]);
    let of_environment = finished(typed.current_dir(&below).env("CANVASS_BUS", "sim:reference-301").output().unwrap());
    assert!(of_environment.status == 0, "{}", of_environment.stderr);
}

#[test]
fn a_bus_that_nobody_names_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    for typed in [&["sdo", "read", "5", "1018:01"][..], &["nmt", "start", "5"], &["lss", "inquire"]] {
        let ended = run_in(folder.path(), typed);
        assert!(ended.status == 2 && ended.stdout.is_empty(), "{typed:?}: {}", ended.stderr);
    }
    let help = run_in(folder.path(), &["sdo", "read", "--help"]);
    assert!(help.stdout.contains("[env: CANVASS_BUS]"), "{}", help.stdout);
}

#[test]
fn mistakes_are_told_with_their_line() {
    for (text, line, problem) in [
        ("bus = \"can0\"\nbusses = 1\n", 2, "unknown field `busses`"),
        ("[timeouts]\nsod = \"1s\"\n", 2, "timeouts.sod"),
        ("[timeouts]\nsdo = \"1 day\"\n", 2, "timeouts.sdo"),
        ("\n\nnode = 128\n", 3, "node"),
        ("[thresholds]\n\"bus/lode.percent\" = 70\n", 2, "bus/lode"),
        ("bus = \n", 1, ""),
    ] {
        let (_folder, below) = project(text);
        let wrong = run_in(&below, &["config"]);
        assert_eq!(wrong.status, 2, "{text}");
        assert!(wrong.stderr.contains(&format!("canvass.toml:{line}: ")), "{text}: {}", wrong.stderr);
        assert!(wrong.stderr.contains(problem), "{text}: {}", wrong.stderr);
        // Commands that use the settings report the error; other commands do not.
        assert_eq!(run_in(&below, &["test", "sim:reference-301"]).status, 2);
        assert_eq!(run_in(&below, &["list", "formats"]).status, 0);
    }
}

#[test]
fn config_says_what_holds_and_whence() {
    let (folder, below) = project(SETTINGS);
    let shown = document(&run_in(&below, &["config", "--format", "json"]));
    assert_eq!(shown["schema"], "canvass/config/1");
    let settings = shown["settings"].as_array().unwrap();
    let of = |key: &str| settings.iter().find(|row| row["key"] == key).unwrap_or_else(|| panic!("{key}"));
    // The canonical form of a path differs on Windows.
    let place = if cfg!(windows) { folder.path().to_owned() } else { folder.path().canonicalize().unwrap() };
    let path = place.join("canvass.toml").display().to_string();
    assert_eq!(of("node"), &serde_json::json!({ "key": "node", "value": "63", "from": format!("{path}:2") }));
    assert_eq!((&of("timeouts.sdo")["value"], &of("timeouts.silence")["from"]), (&"2s".into(), &"default".into()));
    assert_eq!(of("waivers")["from"], "not set");
    // The shown defaults can be typed as options.
    let usual: Vec<(&str, &str)> = shown["settings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|setting| setting["from"] == "default")
        .map(|setting| (setting["key"].as_str().unwrap(), setting["value"].as_str().unwrap()))
        .collect();
    assert!(usual.contains(&("timeouts.silence", "200ms")), "{usual:?}");
    for (key, value) in usual {
        let timeout = format!("{}={value}", key.trim_start_matches("timeouts."));
        let tried = run(&["test", "sim:reference-301", "--dry-run", "--timeout", &timeout]);
        assert_eq!(tried.status, 0, "{timeout}: {}", tried.stderr);
    }
    let table = finished(command(&["config"]).current_dir(&below).env("CANVASS_BUS", "can7").output().unwrap()).stdout;
    assert!(table.lines().next().unwrap().contains("can7") && table.contains("CANVASS_BUS"), "{table}");
}

#[test]
fn a_diagnosis_takes_thresholds_and_devices() {
    let (folder, below) = project(SETTINGS);
    std::fs::write(folder.path().join("a.log"), "(1.000000) can0 73F#00\n").unwrap();
    let found = document(&run_in(&below, &["diagnose", "../a.log", "--format", "json"]));
    let options = found["provenance"]["options"].as_array().unwrap();
    let threshold = options.iter().find(|option| option["name"] == "threshold").unwrap();
    assert_eq!(threshold["value"][0], "bus/load.percent=70");
}
