//! The device descriptions that come with the program are without fault.

use canvass_analyzer::dictionary::{Access, DataType, Setting, Value, eds};
use canvass_analyzer::{Multiplexer, NodeId};

#[test]
fn sendix_58x8() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../conformance/models/kuebler-sendix-58x8.eds");
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
