//! `canvass eds verify`: compares devices with their descriptions.

use crate::running::{run, run_with_input};
use serde_json::Value;

const MODELS: &str = "conformance/device/models";
const ENCODER: &str = "conformance/device/models/reference-406.eds";
const ENCODER_TEXT: &str = include_str!("../../conformance/device/models/reference-406.eds");

/// The exit status and the printed document.
fn json(args: &[&str], input: &str) -> (i32, Value) {
    let run = run_with_input(&[&["eds", "verify"], args, &["--format", "json"]].concat(), input);
    let document = serde_json::from_str(&run.stdout);
    (run.status, document.unwrap_or_else(|error| panic!("{error}: {}{}", run.stdout, run.stderr)))
}

/// The kinds of difference with their addresses, as `length 6004h:00`.
fn kinds(document: &Value) -> Vec<String> {
    let differences = document["differences"].as_array().unwrap().iter();
    let kinds = differences.map(|one| {
        let sub = one["sub"].as_u64().map(|sub| format!(":{sub:02X}")).unwrap_or_default();
        format!("{} {:04X}h{sub}", one["kind"].as_str().unwrap(), one["index"].as_u64().unwrap_or(0))
    });
    kinds.collect()
}

#[test]
fn every_model_is_as_its_file_describes_it() {
    for entry in std::fs::read_dir(MODELS).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|ending| ending != "eds") {
            continue;
        }
        let (file, bus) = (path.to_str().unwrap(), format!("sim:{}", path.file_stem().unwrap().to_str().unwrap()));
        // The object that holds the node-ID differs from its default, as a configured setting.
        let (status, document) = json(&[file, &bus, "--node", "5"], "");
        assert_eq!(status, 0, "{document:#}");
        let others: Vec<String> = kinds(&document).into_iter().filter(|kind| !kind.starts_with("setting")).collect();
        assert_eq!(others, [""; 0], "{file}");
        assert!(document["read"].as_u64().unwrap() > 4_100, "{document:#}");
    }
}

/// Faults stand for the changes of another release of the firmware.
#[test]
fn each_fault_of_a_firmware_is_found() {
    let faults = [
        ("device-type-profile-wrong", "identity 1000h:00"),
        ("vendor-id-zero", "identity 1018h:01"),
        ("identity-revision-missing", "missing-sub-index 1018h:03"),
        ("undescribed-object", "undescribed-object 200Ah"),
        ("default-mapping-wrong", "unmappable 1A00h"),
    ];
    for (fault, expected) in faults {
        let (status, document) = json(&[ENCODER, &format!("sim:reference-406+{fault}"), "--all"], "");
        let kinds = kinds(&document);
        assert!(status == 1 && kinds.iter().any(|kind| kind == expected), "{fault}: {status} {kinds:?}");
    }
}

#[test]
fn each_change_of_a_description_is_found() {
    let changes = [
        ("[6004]\nParameterName=", "[6007]\nParameterName=", "missing-object 6007h"),
        ("[6000]\n", "[6000]\nLowLimit=0x100\n", "limits 6000h:00"),
    ];
    let text = ENCODER_TEXT.replace("\r\n", "\n");
    for (from, to, expected) in changes {
        assert!(text.contains(from), "{from}");
        let (status, document) = json(&["-", "sim:reference-406"], &text.replacen(from, to, 1));
        let kinds = kinds(&document);
        assert!(status == 1 && kinds.iter().any(|kind| kind == expected), "{expected}: {status} {kinds:?}");
    }
}

#[test]
fn text_is_a_table_with_what_each_difference_means() {
    let shown = run(&["eds", "verify", ENCODER, "sim:reference-406+device-type-profile-wrong"]);
    assert_eq!((shown.status, shown.stderr.as_str()), (1, ""));
    assert!(shown.stdout.contains("│ 1000h:00 Device type ┆ identity ┆"), "{}", shown.stdout);
    let summary = format!("{ENCODER}, node 20 on sim:reference-406+device-type-profile-wrong: ");
    let last = shown.stdout.lines().last().unwrap();
    assert!(last.starts_with(&summary) && last.ends_with("entries read, 1 difference"), "{last}");
    assert!(shown.stdout.contains("\nidentity: another device than the description is for"), "{}", shown.stdout);
    let markdown =
        run(&["eds", "verify", ENCODER, "sim:reference-406+undescribed-object", "--all", "--format", "markdown"]);
    assert!(
        markdown.status == 1 && markdown.stdout.contains("| 200Ah | undescribed-object | nothing |"),
        "{}",
        markdown.stdout
    );
}

#[test]
fn what_may_be_configured_fails_only_as_delivered() {
    let file = "conformance/device/models/kuebler-d125.eds";
    let args = ["eds", "verify", file, "sim:kuebler-d125", "--node", "5"];
    let configured = run(&args);
    assert!(configured.status == 0 && configured.stdout.contains("may be configuration"), "{}", configured.stdout);
    assert_eq!(run(&[&args[..], &["--as-delivered"]].concat()).status, 1);
    assert_eq!(run(&["eds", "verify", file, "sim:kuebler-d125", "--as-delivered"]).status, 0);
}

#[test]
fn a_device_that_does_not_answer_is_no_difference() {
    let silent = run(&["eds", "verify", ENCODER, "sim:reference-406:5", "--node", "9", "--timeout", "50ms"]);
    assert_eq!((silent.status, silent.stdout.as_str()), (3, ""));
    assert!(silent.stderr.contains("node 9 does not answer"), "{}", silent.stderr);
    let file = run(&["eds", "verify", "no-such.eds", "sim:reference-406"]);
    assert!(file.status == 2 && file.stderr.contains("no-such.eds"), "{}", file.stderr);
    // If a device is silent for absent objects, the survey gives up instead of waiting for 4000 timeouts.
    let (status, document) = json(&[ENCODER, "sim:reference-406+sdo-no-object-silent"], "");
    assert_eq!((status, document["given_up_at"].is_u64()), (0, true), "{document:#}");
}

#[test]
fn every_kind_of_difference_is_documented() {
    let docs = std::fs::read_to_string("docs/eds.md").unwrap();
    for kind in canvass_analyzer::dictionary::survey::compare::MismatchKind::ALL {
        assert!(docs.contains(&format!("`{}`", kind.id())), "{kind:?}");
    }
}
