//! The device descriptions that come with the program are without fault.

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
