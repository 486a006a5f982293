//! Devices with descriptions of other manufacturers and of several profiles: a device that is simulated from its
//! description alone fails no case.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_suite::bench::Target;
use canvass_suite::catalogue;
use canvass_suite::selftest::judge_target;
use canvass_suite::verdict::Kind;

/// Runs every case with everything allowed, and requires exactly these bad verdicts.
fn check(eds: &[u8], expected: &[(&str, Kind)]) {
    let model: &'static Model = Box::leak(Box::new(Model::generic("published.eds", eds).unwrap()));
    let target = Target::of(model, model.default_node().unwrap());
    let (mut wrong, mut seen) = (Vec::new(), Vec::new());
    for case in catalogue::cases() {
        let report = judge_target(case, model, Faults::NONE, &target);
        let kind = report.verdict.kind();
        if !matches!(kind, Kind::Fail | Kind::Error | Kind::Inconclusive) {
            continue;
        }
        seen.push((case.id, kind));
        let reason = report.verdict.reason().map(|reason| reason.to_string()).unwrap_or_default();
        let is_said = report.notes.iter().any(|note| note.contains("is simulated as published.eds describes it"));
        if !expected.contains(&(case.id, kind)) || (kind == Kind::Fail && case.asks_the_device() && !is_said) {
            wrong.push(format!("{}: {kind}: {reason}", case.id));
        }
    }
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
    assert_eq!(seen.len(), expected.len(), "{seen:?}");
}

/// A description of CiA 401 with one-digit hours in the file's dates, and two used entries of eight in a mapping.
#[test]
fn digital_inputs_and_outputs() {
    check(include_bytes!("published/io-module.eds"), &[]);
}

/// A description of CiA 402 with an inhibit time above the event timer, PDOs that are off, limits, and lists out of
/// order.
#[test]
fn a_drive() {
    check(include_bytes!("published/drive.eds"), &[]);
}

/// A description of CiA 406 without manufacturer objects.
#[test]
fn a_plain_encoder() {
    check(include_bytes!("published/plain-encoder.eds"), &[]);
}

/// A description with a TPDO that is on and maps nothing, an identity without defaults, a parameter that must not be
/// changed (ObjFlags), names in Latin-1, and comments after values.
#[test]
fn a_device_with_little() {
    check(include_bytes!("published/bare.eds"), &[]);
}

/// An object is mapped with another length than that of its data type.
const MAPPED_SHORT: [(&str, Kind); 2] = [("301/pdo/mapping/default", Kind::Fail), ("306/objects/mapping", Kind::Fail)];
/// An object has another data type or object code than in the standard.
const OTHER_TYPE: (&str, Kind) = ("306/objects/standard", Kind::Fail);

/// The errors in the description of a built-in model.
fn errors(id: &str) -> Vec<(&'static str, Kind)> {
    match id {
        "kuebler-c100" | "kuebler-sendix-f58" => vec![MAPPED_SHORT[0], MAPPED_SHORT[1], OTHER_TYPE],
        "kuebler-d125" | "kuebler-sendix-58x8" | "kuebler-sendix-f58m" | "kuebler-sendix-m58" => vec![OTHER_TYPE],
        // The description has class C2 but no 6503h.
        "lika-ax58" => vec![("406/profile/mandatory-objects", Kind::Fail)],
        // The description has no 1018h.
        "tr-c65" => vec![
            ("301/identity/mandatory-objects", Kind::Fail),
            ("301/identity/vendor-id", Kind::Fail),
            ("301/sdo/block-download/read-only", Kind::Inconclusive),
        ],
        // 1018h:00 has four bytes in the description.
        "tr-lmp30" => {
            vec![("301/identity/mandatory-objects", Kind::Fail), ("301/sdo/upload/expedited", Kind::Fail), OTHER_TYPE]
        }
        _ => Vec::new(),
    }
}

/// Each built-in model, simulated from its description alone: no case fails because the model's sheet is missing. Each
/// failure is an error in the description, and its report says so.
macro_rules! alone {
    ($($name:ident = $id:literal,)*) => {
        $(#[test]
        fn $name() {
            check(include_bytes!(concat!("../../device/models/", $id, ".eds")), &errors($id));
        })*
    };
}

canvass_device::each_model!(alone);
