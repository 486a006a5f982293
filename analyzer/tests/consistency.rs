//! Contradictions in device descriptions.

use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::{DataType, DeviceDescription, Object, ObjectCode, Setting, Value, consistency, eds};

const SENDIX: &str = include_str!("../../conformance/device/models/kuebler-sendix-58x8.eds");

/// The problems after one replacement in the Sendix EDS, without the problems of the unchanged EDS.
fn found(from: &str, to: &str) -> Vec<String> {
    assert!(SENDIX.contains(from), "{from}");
    let description = eds::read(SENDIX.replacen(from, to, 1).as_bytes()).unwrap_or_default();
    let known: Vec<String> = problems(&eds::read(SENDIX.as_bytes()).unwrap_or_default());
    problems(&description).into_iter().filter(|problem| !known.contains(problem)).collect()
}

/// The problems as text, without their lines.
fn problems(description: &DeviceDescription) -> Vec<String> {
    let problems = consistency::check(description).into_iter();
    problems.map(|problem| format!("[{}] {}: {}", problem.section, problem.field, problem.found)).collect()
}

#[test]
fn what_the_manual_of_the_sendix_has_otherwise_than_the_standards() {
    let description = eds::read(SENDIX.as_bytes()).unwrap();
    let expected = [
        "[1015] DataType: UNSIGNED32 instead of UNSIGNED16",
        "[6401sub1] DataType: UNSIGNED32 instead of INTEGER32",
        "[6401sub2] DataType: UNSIGNED32 instead of INTEGER32",
        "[6402sub1] DataType: UNSIGNED32 instead of INTEGER32",
        "[6402sub2] DataType: UNSIGNED32 instead of INTEGER32",
    ];
    assert_eq!(problems(&description), expected);
    assert!(consistency::check(&description).iter().all(|problem| problem.line > 0));
    assert_eq!(description.device_profile(), Some(406));
}

#[test]
fn identity_and_device_info_agree() {
    assert_eq!(
        found("VendorNumber=0x00000013", "VendorNumber=0x00000014"),
        ["[1018sub1] DefaultValue: 13h instead of 14h"]
    );
}

#[test]
fn default_mappings_work() {
    let expected = [
        // One bit too few, no such sub-index, not mappable, no such object, a dummy entry.
        ("0x6030010F", "6030h:01 with 15 bits"),
        ("0x60300210", "6030h:02 with 16 bits"),
        ("0x65030010", "6503h:00 with 16 bits"),
        ("0x70000010", "7000h:00 with 16 bits"),
        ("0x00060010", "0006h:00 with 16 bits"),
    ];
    for (mapped, problem) in expected {
        let found = found("DefaultValue=0x60300110", &format!("DefaultValue={mapped}"));
        assert_eq!(found.first(), Some(&format!("[1A02sub1] DefaultValue: {problem}")), "{mapped}");
    }
}

#[test]
fn a_mapping_has_at_most_64_bits_and_no_empty_entries() {
    let mut description = eds::read(SENDIX.as_bytes()).unwrap();
    let mapping = description.dictionary.object_mut(canvass_analyzer::Index(0x1A00)).unwrap();
    for (sub, value) in [(0, 4), (2, 0x6004_0020), (3, 0x6004_0020)] {
        let entry = mapping.entry_mut(canvass_analyzer::SubIndex(sub)).unwrap();
        entry.default = Some(Setting::Fixed(Value::Unsigned(value)));
    }
    mapping.entry_mut(canvass_analyzer::SubIndex(4)).unwrap().default = None;
    let found = problems(&description);
    assert!(found.contains(&"[1A00sub4] DefaultValue: none".to_owned()), "{found:?}");
    assert!(found.contains(&"[1A00sub0] DefaultValue: 96 bits".to_owned()), "{found:?}");
}

#[test]
fn cob_ids_are_allowed_and_used_once() {
    assert_eq!(found("$NODEID+0x280", "$NODEID+0x180")[0], "[1801sub1] DefaultValue: $NODEID+180h as in 1800h:01");
    assert_eq!(found("$NODEID+0x280", "$NODEID+0x580")[0], "[1801sub1] DefaultValue: 581h");
    assert_eq!(found("$NODEID+0x280", "$NODEID+0x80000180"), [] as [&str; 0]);
}

#[test]
fn reserved_transmission_types_are_found() {
    assert_eq!(found("DefaultValue=0x01", "DefaultValue=251"), ["[1801sub2] DefaultValue: 251"]);
    assert_eq!(found("DefaultValue=0x01", "DefaultValue=252"), [] as [&str; 0]);
}

#[test]
fn parameters_of_a_pdo_come_in_pairs_and_arrays_have_one_type() {
    let mut description = eds::read(SENDIX.as_bytes()).unwrap();
    description.dictionary.insert(Object::new(0x1A05, "alone", ObjectCode::RECORD));
    let array = description.dictionary.object_mut(canvass_analyzer::Index(0x2140)).unwrap();
    array.entry_mut(canvass_analyzer::SubIndex(2)).unwrap().data_type = DataType::UNSIGNED8;
    let found = problems(&description);
    assert!(found.contains(&"[1A05sub0] : no 1805h".to_owned()), "{found:?}");
    assert!(found.contains(&"[2140sub2] DataType: UNSIGNED8".to_owned()), "{found:?}");
    assert!(description.dictionary.entry(Multiplexer::new(0x1A05, 0)).is_err());
}
