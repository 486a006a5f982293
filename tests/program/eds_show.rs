//! `canvass eds show`: a description to read.

use crate::running::{run, run_with_input};
use serde_json::Value;

const ENCODER: &str = "conformance/device/models/reference-406.eds";

#[test]
fn every_described_object_is_in_every_form() {
    let json = run(&["eds", "show", ENCODER, "--format", "json"]);
    let document: Value = serde_json::from_str(&json.stdout).unwrap();
    let objects = document["objects"].as_array().unwrap();
    assert_eq!((json.status, document["schema"].as_str(), objects.len()), (0, Some("canvass/eds-show/1"), 92));
    let forms = ["text", "markdown", "html"].map(|form| run(&["eds", "show", ENCODER, "--format", form]).stdout);
    for object in objects {
        let index = format!("{:04X}h", object["index"].as_u64().unwrap());
        assert!(forms.iter().all(|form| form.contains(&index)), "{index}");
    }
    for pdo in document["pdos"].as_array().unwrap() {
        assert!(forms.iter().all(|form| form.contains(pdo["pdo"].as_str().unwrap())), "{pdo}");
    }
    assert!(forms[2].starts_with("<!DOCTYPE html>") && forms[2].ends_with("</html>\n"));
}

#[test]
fn pdos_are_drawn_in_80_columns() {
    let shown = run(&["eds", "show", ENCODER, "1A03"]);
    let expected = "\nTPDO 4: 40 bits, CAN-ID $NODEID+480h, switched off, no remote frames\n  \
        transmission type 254 (on events of the manufacturer)\n  byte 0       1       2       3       4\n       \
        A──────┤B──────────────┤C──────────────┤\n  A    bits 0 to 7    6400h:01 Work area state channel 1, UNSIGNED8\n  \
        B    bits 8 to 23   6503h:00 Alarms, UNSIGNED16\n  C    bits 24 to 39  6505h:00 Warnings, UNSIGNED16\n";
    assert!(shown.status == 0 && shown.stdout.ends_with(expected), "{}", shown.stdout);
    let all = run(&["eds", "show", ENCODER]);
    let pdos = all.stdout.find("TPDO 1:").unwrap();
    assert!(all.stdout[pdos..].lines().all(|line| line.chars().count() <= 80), "{}", all.stdout);
}

#[test]
fn an_object_is_chosen_by_index_or_name() {
    for object in ["6004", "Position value", "position value", "0x6004"] {
        let shown = run(&["eds", "show", ENCODER, object, "--node", "5"]);
        assert!(
            shown.stdout.starts_with("6004h Position value: VAR\n  CiA 406: Position value, VAR\n"),
            "{}",
            shown.stdout
        );
        assert!(shown.stdout.contains("TPDO 1: 32 bits, CAN-ID 185h"), "{}", shown.stdout);
    }
    let none = run(&["eds", "show", ENCODER, "2FFF"]);
    assert!(none.status == 2 && none.stderr.contains("has no object 2FFFh"), "{}", none.stderr);
    assert_eq!(run(&["eds", "show", ENCODER, "nonsense"]).status, 2);
    assert_eq!(run_with_input(&["eds", "show", "-"], "nothing").status, 2);
}

#[test]
fn a_dcf_shows_what_it_configures() {
    let text = std::fs::read_to_string(ENCODER).unwrap().replace("\r\n", "\n");
    let dcf = format!("{text}\n[DeviceComissioning]\nNodeID=9\nNodeName=a\nBaudrate=250\n").replacen(
        "[1017]\n",
        "[1017]\nParameterValue=250\n",
        1,
    );
    let shown = run_with_input(&["eds", "show", "-"], &dcf);
    assert!(shown.stdout.contains("configured") && shown.stdout.contains("CAN-ID 189h"), "{}", shown.stdout);
    let one = run_with_input(&["eds", "show", "-", "1017"], &dcf);
    assert!(one.stdout.contains("\n    configured 250\n"), "{}", one.stdout);
}
