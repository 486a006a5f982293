//! The device descriptions that come with the program are without fault.

use canvass_analyzer::dictionary::editor::rename;
use canvass_analyzer::dictionary::source::Source;
use canvass_analyzer::dictionary::{Access, DataType, Setting, Value, consistency, eds};
use canvass_analyzer::{Multiplexer, NodeId};

#[test]
fn sendix_58x8() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../conformance/device/models/kuebler-sendix-58x8.eds");
    let description = eds::read(&std::fs::read(path).unwrap()).unwrap();
    assert!(description.problems.is_empty(), "{:#?}", description.problems);
    assert_eq!(description.device.bit_rates, [10, 20, 50, 125, 250, 500, 800, 1000]);
    assert!(description.device.lss_supported);
    assert_eq!((description.device.rpdos, description.device.tpdos), (0, 3));
    assert!(!description.is_configuration());

    let entry = |index, sub| description.dictionary.entry(Multiplexer::new(index, sub)).unwrap();
    let node = NodeId::new(63).unwrap();
    assert_eq!(entry(0x1000, 0).default, Some(Setting::Fixed(Value::Unsigned(0x0002_0196))));
    assert_eq!(entry(0x1008, 0).start_value(node), Some(Value::VisibleString(b"Kuebler Sendix Encoder".to_vec())));
    assert_eq!(entry(0x1014, 0).access, Access::Ro);
    assert_eq!(entry(0x1800, 1).start_value(node), Some(Value::Unsigned(0x1BF)));
    assert_eq!(entry(0x1A02, 1).start_value(node), Some(Value::Unsigned(0x6030_0110)));
    assert_eq!(entry(0x6030, 1).data_type, DataType::INTEGER16);
    assert!(entry(0x6004, 0).pdo_mappable && !entry(0x6002, 0).pdo_mappable);
    assert!(description.dictionary.entry(Multiplexer::new(0x1800, 4)).is_err());
}

/// Each row has the model, its number of sub-indexes, and whether it supports LSS.
#[test]
fn the_other_encoders() {
    for (model, sub_indexes, has_lss) in [
        ("kuebler-sendix-f58", 159, true),
        ("kuebler-sendix-m58", 138, true),
        ("kuebler-sendix-f58m", 150, true),
        ("kuebler-c100", 51, true),
        ("kuebler-d125", 51, true),
        ("lika-ax58", 59, false),
        ("tr-c65", 49, false),
        ("tr-lmp30", 54, false),
        ("reference-406", 229, true),
    ] {
        let path = format!("{}/../conformance/device/models/{model}.eds", env!("CARGO_MANIFEST_DIR"));
        let description = eds::read(&std::fs::read(path).unwrap()).unwrap();
        assert!(description.problems.is_empty(), "{model}: {:#?}", description.problems);
        assert_eq!(description.device_profile(), Some(406), "{model}");
        assert_eq!(description.device.lss_supported, has_lss, "{model}");
        assert_eq!(description.dictionary.entries().count(), sub_indexes, "{model}");
    }
}

/// Contradictions between the manuals of Lika and TR-Electronic and the standards.
#[test]
fn contradictions_to_the_standards() {
    let found = |model: &str| -> Vec<String> {
        let path = format!("{}/../conformance/device/models/{model}.eds", env!("CARGO_MANIFEST_DIR"));
        let description = eds::read(&std::fs::read(path).unwrap()).unwrap();
        let problems = consistency::check(&description).into_iter();
        problems.map(|problem| format!("[{}] {}: {}", problem.section, problem.field, problem.found)).collect()
    };
    assert_eq!(found("lika-ax58"), ["[1003sub3] ParameterName: Older error occurred"]);
    // The second TPDO in use is TPDO 3. The standard allows PDOs that can't be configured.
    let both = ["[100E] AccessType: ro instead of rw", "[1802sub1] DefaultValue: $NODEID+280h"];
    assert_eq!(found("tr-c65"), [&["[1018] : none"], &both[..]].concat());
    let count = "[1018sub0] DataType: UNSIGNED32 instead of UNSIGNED8";
    assert_eq!(found("tr-lmp30"), [&[count], &both[..]].concat());
}

/// In every description of the project, each object gets another index and its own one back: meanwhile the dictionary has
/// the same objects but for that index, and nothing is left of the old one.
#[test]
fn every_object_takes_another_index_and_comes_back() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../conformance/device/models");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut tried = 0;
    for path in files.filter(|path| path.extension().is_some_and(|extension| extension == "eds")) {
        let text = String::from_utf8_lossy(&std::fs::read(&path).unwrap()).into_owned();
        let indexes = |text: &str| -> Vec<u16> {
            let description = eds::read(text.as_bytes()).unwrap();
            let mut all: Vec<u16> = description.dictionary.entries().map(|(at, _)| at.index.0).collect();
            all.sort_unstable();
            all
        };
        let before = indexes(&text);
        let free = (0x5000..0x6000).find(|index| !before.contains(index)).unwrap();
        let moved = |text: &str, from: u16, to: u16| -> Option<String> {
            let at = text.find(&format!("[{from:04X}]"))? + 2;
            let mut changed = text.to_owned();
            for (range, digits) in rename(&Source::of_text(text), at, to)?.into_iter().rev() {
                changed.replace_range(range, &digits);
            }
            Some(changed)
        };
        for index in before.iter().copied().collect::<std::collections::BTreeSet<u16>>() {
            let Some(there) = moved(&text, index, free) else { continue };
            let mut expected: Vec<u16> = before.iter().map(|at| if *at == index { free } else { *at }).collect();
            expected.sort_unstable();
            assert_eq!(indexes(&there), expected, "{}: {index:04X}h", path.display());
            let back = moved(&there, free, index).unwrap();
            assert!(back.eq_ignore_ascii_case(&text), "{}: {index:04X}h", path.display());
            tried += 1;
        }
    }
    assert!(tried > 300, "{tried}");
}
