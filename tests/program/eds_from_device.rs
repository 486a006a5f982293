//! `canvass eds from-device`: descriptions made from devices, as `eds check` and `eds verify` judge them.

use crate::running::run;
use serde_json::Value;
use std::path::Path;

fn models() -> Vec<String> {
    let listed: Value = serde_json::from_str(&run(&["list", "models", "--format", "json"]).stdout).unwrap();
    listed.as_array().unwrap().iter().map(|model| model["id"].as_str().unwrap().to_owned()).collect()
}

/// Makes a description of the simulated device; no model has objects above 67FFh.
fn described(folder: &Path, bus: &str) -> String {
    let path = folder.join("device.eds").display().to_string();
    let made = run(&["eds", "from-device", bus, "--node", "5", "-o", &path, "--force", "--range", "1000-67FF"]);
    assert_eq!((made.status, made.stdout.as_str()), (0, ""), "{}", made.stderr);
    path
}

/// The kinds of difference between a device and the file.
fn differences(file: &str, bus: &str, more: &[&str]) -> Vec<String> {
    let args = ["eds", "verify", file, bus, "--node", "5", "--as-delivered", "--format", "json"];
    let verified = run(&[&args, more].concat());
    let document: Value = serde_json::from_str(&verified.stdout).unwrap();
    let differences: Vec<&Value> = document["differences"].as_array().unwrap().iter().collect();
    let counted = differences.iter().any(|one| one["counts"] == true);
    assert_eq!(verified.status, i32::from(counted), "{document:#}");
    let shown = differences.into_iter().map(|one| {
        let index = one["index"].as_u64().map(|index| format!(" {index:04X}h")).unwrap_or_default();
        let sub = one["sub"].as_u64().map(|sub| format!(":{sub:02X}")).unwrap_or_default();
        format!("{}{index}{sub}", one["kind"].as_str().unwrap())
    });
    shown.collect()
}

#[test]
fn every_model_is_as_it_was_described_and_its_file_is_sound() {
    let folder = tempfile::tempdir().unwrap();
    let models = models();
    assert!(models.contains(&"reference-301".to_owned()), "{models:?}");
    for model in models {
        let bus = format!("sim:{model}");
        let file = described(folder.path(), &bus);
        let checked = run(&["eds", "check", &file]);
        assert_eq!(checked.status, 0, "{model}: {}", checked.stdout);
        assert_eq!(differences(&file, &bus, &[]), [""; 0], "{model}");
    }
}

/// Each firmware with a fault differs from the description, in the expected object.
#[test]
fn another_firmware_differs_from_what_was_described() {
    let folder = tempfile::tempdir().unwrap();
    let file = described(folder.path(), "sim:reference-406");
    let faults = [
        ("device-type-profile-wrong", "identity 1000h:00"),
        ("vendor-id-zero", "identity 1018h:01"),
        ("identity-revision-missing", "missing-sub-index 1018h:03"),
        ("undescribed-object", "undescribed-object 200Ah"),
        ("default-mapping-wrong", "mapping 1A00h"),
    ];
    for (fault, expected) in faults {
        let found = differences(&file, &format!("sim:reference-406+{fault}"), &["--all"]);
        assert!(found.iter().any(|one| one == expected), "{fault}: {found:?}");
    }
}

/// A release of a firmware with one changed object differs from the description in this object.
#[test]
fn each_change_of_a_release_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let text = include_str!("../../conformance/device/models/reference-406.eds").replace("\r\n", "\n");
    let release = |text: &str| {
        let path = folder.path().join("release.eds");
        std::fs::write(&path, text).unwrap();
        format!("sim:{}", path.display())
    };
    let file = described(folder.path(), &release(&text));
    assert_eq!(differences(&file, &release(&text), &["--all"]), [""; 0]);
    for (section, from, to, expected) in CHANGES {
        let at = text.find(&format!("[{section}]\n")).unwrap();
        let (before, after) = text.split_at(at);
        assert!(after.contains(from), "[{section}] {from}");
        let found = differences(&file, &release(&format!("{before}{}", after.replacen(from, to, 1))), &[]);
        assert_eq!(found, [*expected], "[{section}] {from} -> {to}");
    }
}

/// A section, the replaced line and the new line in it, and the expected difference.
#[rustfmt::skip]
const CHANGES: &[(&str, &str, &str, &str)] = &[
    ("6000", "DataType=0x0006", "DataType=0x0007", "length 6000h:00"),
    ("1017", "AccessType=rw", "AccessType=wo", "access 1017h:00"),
    ("1018sub2", "DefaultValue=0x00000406", "DefaultValue=7", "identity 1018h:02"),
    ("1018sub3", "DefaultValue=0x00010000", "DefaultValue=7", "release 1018h:03"),
    ("1800sub1", "$NODEID+0x40000180", "$NODEID+0x40000190", "cob-id 1800h:01"),
];

#[test]
fn ranges_and_outputs_are_chosen() {
    let part = run(&["eds", "from-device", "sim:reference-406", "--range", "1000-1001", "--range", "6004"]);
    assert_eq!(part.status, 0, "{}", part.stderr);
    assert!(part.stdout.contains("[6004]\r\nParameterName=Position value\r\n"), "{}", part.stdout);
    assert!(!part.stdout.contains("[6000]") && !part.stdout.contains("[1017]"), "{}", part.stdout);
    assert!(part.stderr.starts_with("canvass: 4 objects with "), "{}", part.stderr);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.eds");
    std::fs::write(&file, "mine").unwrap();
    let kept = run(&["eds", "from-device", "sim:reference-406", "-o", file.to_str().unwrap(), "--range", "1000"]);
    assert_eq!((kept.status, std::fs::read_to_string(&file).unwrap().as_str()), (2, "mine"), "{}", kept.stderr);
    let wrong = run(&["eds", "from-device", "sim:reference-406", "--range", "2000-1000"]);
    assert!(wrong.status == 2 && wrong.stderr.contains("expected indexes from 1000 to FFFF"), "{}", wrong.stderr);
    let silent = run(&["eds", "from-device", "sim:reference-406:5", "--node", "9", "--timeout", "20ms"]);
    assert!(silent.status == 3 && silent.stderr.contains("node 9 does not answer"), "{}", silent.stderr);
    let waits = run(&["eds", "from-device", "sim:reference-406+sdo-no-object-silent", "--timeout", "20ms"]);
    assert!(waits.status == 3 && waits.stderr.contains("name the indexes with --range"), "{}", waits.stderr);
}
