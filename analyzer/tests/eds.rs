//! Oddities of device descriptions: each file in `eds/` is `plain.eds` with one oddity.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use canvass_analyzer::dictionary::eds::{self, DescriptionError};
use canvass_analyzer::dictionary::{DeviceDescription, Entry, Object, ObjectCode, Severity, Value, consistency};
use canvass_analyzer::{Index, Multiplexer, NodeId, SubIndex};
use proptest::prelude::*;

#[path = "eds/harmless.rs"]
mod harmless;
#[path = "eds/table.rs"]
mod table;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/eds")
}

/// The bytes of a file; empty, and so no description, if there is no such file.
fn bytes(name: &str) -> Vec<u8> {
    std::fs::read(folder().join(name).with_extension("eds")).unwrap_or_default()
}

fn read(name: &str) -> Result<DeviceDescription, DescriptionError> {
    eds::read(&bytes(name))
}

/// The problems as text: severity, kind, section, field, and the text of the line that the problem names.
fn problems(name: &str, description: &DeviceDescription) -> Vec<String> {
    let text: String = bytes(name).iter().map(|&byte| char::from(byte)).collect();
    let lines: Vec<&str> = text.lines().collect();
    let shown = |line: u32| match line {
        0 | 1 => String::new(),
        _ => lines[line as usize - 1].trim().escape_debug().to_string().chars().take(40).collect(),
    };
    let problem = |problem: &canvass_analyzer::dictionary::EdsProblem| {
        let line = shown(problem.line);
        format!("{} {:?} [{}] {} @ {line}", problem.severity(), problem.kind(), problem.section, problem.field)
    };
    description.problems.iter().map(problem).collect()
}

fn address(object: &Object, entry: &Entry) -> String {
    format!("{:04X}:{:02X}", object.index.0, entry.sub.0)
}

/// The entries of the file from 1017h on, as they were read.
fn reads(description: &DeviceDescription) -> Vec<(String, String)> {
    let objects =
        description.dictionary.objects().iter().filter(|object| object.index >= Index(0x1017) && object.line != 0);
    let entries = objects.flat_map(|object| object.entries().iter().map(move |entry| (object, entry)));
    let shown = |(object, entry): (&Object, &Entry)| {
        let default = entry.default.as_ref().map_or("-".to_owned(), ToString::to_string);
        let (name, code) = (entry.name.escape_debug(), object.code);
        let address = address(object, entry);
        let text = format!("{address} {code} {name}: {} {} {default}", entry.data_type, entry.access);
        (address, text)
    };
    entries.map(shown).collect()
}

/// The entries that were read differently from the entries of `plain.eds`.
fn differences(plain: &DeviceDescription, description: &DeviceDescription) -> Vec<String> {
    let (plain, found) = (reads(plain), reads(description));
    let addresses: BTreeSet<&str> = found.iter().map(|(address, _)| address.as_str()).collect();
    let lost = plain.iter().filter(|(address, _)| !addresses.contains(address.as_str()));
    let lost = lost.map(|(address, _)| format!("lost {address}"));
    let other = found.iter().filter(|entry| !plain.contains(entry)).map(|(_, text)| text.clone());
    lost.chain(other).collect()
}

#[test]
fn each_oddity_is_understood_and_named_with_line_and_field() {
    let plain = read("plain").unwrap();
    let mut wrong = Vec::new();
    for &(name, expected_problems, expected_reads) in table::CASES {
        let description = read(name).unwrap();
        let found = (problems(name, &description), differences(&plain, &description));
        if found.0 != expected_problems || found.1 != expected_reads {
            wrong.push((name, found));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn each_file_is_in_the_table() {
    let files = std::fs::read_dir(folder()).unwrap().map(|file| file.unwrap().path());
    let files: BTreeSet<String> = files
        .filter(|path| path.extension().is_some_and(|extension| extension == "eds"))
        .map(|path| path.file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    let cases: BTreeSet<String> = table::CASES.iter().map(|(name, ..)| (*name).to_owned()).collect();
    assert_eq!(files, cases);
}

#[test]
fn compact_pdos_are_filled_in() {
    let description = read("compact-pdo").unwrap();
    let entry = |index, sub| description.dictionary.entry(Multiplexer::new(index, sub));
    let node = NodeId::new(5).unwrap();
    // Described entries stay. The mask 13h adds COB-ID, transmission type and event timer.
    assert_eq!(entry(0x1800, 0).unwrap().start_value(node), Some(Value::Unsigned(2)));
    assert_eq!(entry(0x1801, 1).unwrap().start_value(node), Some(Value::Unsigned(0x285)));
    assert!(entry(0x1801, 3).is_err() && entry(0x1801, 5).is_ok());
    assert!(entry(0x1A01, 64).is_ok() && entry(0x1802, 0).is_err());
}

#[test]
fn modules_have_fixed_objects_and_extensions() {
    let modules = read("modules").unwrap().modules;
    let [inputs, outputs] = modules.as_slice() else { panic!("{modules:?}") };
    assert_eq!((inputs.number, inputs.product_name.as_str(), inputs.order_code.as_str()), (1, "8 inputs", "DI8"));
    assert_eq!(inputs.fixed_objects[0].index, Index(0x6423));
    assert_eq!(inputs.fixed_objects[0].code, ObjectCode::VAR);
    assert_eq!((inputs.extensions[0].template.index, inputs.extensions[0].count), (Index(0x6000), 2));
    assert!(inputs.extensions[0].template.entry(SubIndex(1)).unwrap().pdo_mappable);
    assert_eq!(outputs.number, 3);
}

#[test]
fn a_dcf_tells_how_one_device_is_configured() {
    let description = read("dcf").unwrap();
    let commissioning = description.commissioning.as_ref().unwrap();
    assert_eq!((commissioning.node_id, commissioning.bit_rate), (NodeId::new(16), Some(250)));
    assert_eq!((commissioning.node_name.as_str(), commissioning.lss_serial_number), ("Left", Some(7)));
    assert_eq!(description.file.last_eds.as_deref(), Some("plain.eds"));
    let entry = description.dictionary.entry(Multiplexer::new(0x2000, 0)).unwrap();
    assert_eq!(entry.start_value(NodeId::MIN), Some(Value::Unsigned(77)));
    assert_eq!(entry.denotation.as_deref(), Some("Limit of the door"));
    assert!(description.is_configuration() && !read("plain").unwrap().is_configuration());
}

/// Many DCFs lack the section of a configured device; their values count all the same. Only what calls itself an EDS has
/// none.
#[test]
fn configured_values_count_unless_the_file_is_an_eds() {
    let of = |head: &str| {
        let entry = |index: &str| {
            format!(
                "[{index}]\nParameterName=Time {index}\nObjectType=7\nDataType=6\nAccessType=rw\nParameterValue=100\n"
            )
        };
        let text = format!("{head}{}{}", entry("1017"), entry("2000"));
        let description = eds::read(text.as_bytes()).unwrap();
        let values = description.dictionary.entries().filter(|(_, entry)| entry.configured.is_some()).count();
        let told = |problem: &&canvass_analyzer::dictionary::EdsProblem| problem.rule.id == "eds/field/configured";
        let found: Vec<String> =
            description.problems.iter().filter(told).map(|problem| problem.found.clone()).collect();
        (values, found)
    };
    let kept = (2, Vec::new());
    assert_eq!(of(""), kept);
    assert_eq!(of("[FileInfo]\nFileName=robot.dcf\n"), kept);
    assert_eq!(of("[FileInfo]\nFileName=robot.eds\n[DeviceComissioning]\nNodeID=5\n"), kept);
    assert_eq!(of("[FileInfo]\nFileName=Robot.EDS\n"), (0, vec!["2 values, the first is 100".to_owned()]));
}

#[test]
fn header_fields_are_read() {
    let description = read("plain").unwrap();
    assert_eq!(description.device.bit_rates, [125, 250]);
    assert_eq!((description.device.vendor_number, description.device.tpdos), (Some(1), 1));
    assert_eq!(description.dummy_usage.get(&5), Some(&true));
    assert_eq!(description.comments, ["one"]);
    assert_eq!(description.lists.mandatory.iter().map(|(index, _)| index.0).collect::<Vec<_>>(), [0x1000, 0x1001]);
    assert_eq!(read("word-for-flag").unwrap().device.bit_rates, [125, 250]);
    let flags = read("object-flags").unwrap().dictionary.entry(Multiplexer::new(0x2000, 0)).unwrap().flags;
    assert!(flags.refuses_write_on_download() && flags.refuses_read_on_scan());
}

#[test]
fn what_is_no_description_is_refused() {
    assert_eq!(eds::read(b"").unwrap_err(), DescriptionError::NoSections);
    assert_eq!(eds::read(b"(1.0) can0 000#0100\n").unwrap_err(), DescriptionError::NoSections);
    assert_eq!(eds::read(b"[core]\nbare=false\n").unwrap_err(), DescriptionError::NoSections);
    assert!(matches!(eds::read(&vec![b'\n'; (16 << 20) + 1]), Err(DescriptionError::TooLarge { .. })));
}

#[test]
fn compact_objects_cannot_fill_the_memory() {
    let text: String = (0..=0xFFFF).map(|index| format!("[{index:04X}]\nCompactSubObj=254\n")).collect();
    let description = eds::read(text.as_bytes()).unwrap();
    assert!(description.dictionary.entries().count() <= 200_000);
    assert!(description.problems.len() <= 10_001);
}

#[test]
fn the_largest_numbers_do_no_harm() {
    let text = b"[OptionalObjects]\n4294967295=0x6000\n[6000]\nObjectType=8\nDataType=7\nCompactSubObj=254\n";
    let description = eds::read(text).unwrap();
    assert_eq!(description.dictionary.entries().count(), 255);
    assert!(!consistency::check(&description).is_empty());
}

fn check(bytes: &[u8]) -> Result<(), TestCaseError> {
    let Ok(description) = eds::read(bytes) else { return Ok(()) };
    for problem in description.problems.iter().chain(&consistency::check(&description)) {
        prop_assert!(problem.severity() == Severity::Hint || !problem.section.is_empty() || problem.line != 0);
    }
    harmless::check(&description)
}

proptest! {
    #[test]
    fn random_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        check(&bytes)?;
    }

    #[test]
    fn random_text_of_the_right_words_does_no_harm(
        words in prop::collection::vec(
            prop::sample::select(vec![
                "[", "]", "=", "\n", ";", "\r", "0x", "1018", "sub", "Value", "Name", "M1", "Fixed", "SubExt", "FileInfo",
                "DeviceInfo", "SubNumber", "CompactSubObj", "CompactPDO", "ObjectType", "DataType", "DefaultValue",
                "LowLimit", "HighLimit", "AccessType", "$NODEID", "+", "-", "0", "7", "8", "9", "254", "255", "65535", "4294967295", "99999999999", "Mandatory", "Objects", "Supported", "é",
            ]),
            0..300,
        ),
    ) {
        check(words.concat().as_bytes())?;
    }

    #[test]
    fn damaged_files_do_no_harm(
        case in 0..table::CASES.len(),
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 0..3), 1..20),
    ) {
        let mut bytes = bytes(table::CASES[case].0);
        for (place, byte, how) in damage {
            let place = place.index(bytes.len());
            match how {
                0 => bytes[place] = byte,
                1 => bytes.insert(place, byte),
                _ => drop(bytes.drain(place..(place + usize::from(byte)).min(bytes.len() - 1))),
            }
        }
        check(&bytes)?;
    }
}
