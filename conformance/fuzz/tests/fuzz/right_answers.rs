//! Answers that the oracle and the cases once judged differently, or more strictly than CiA 301. The tests say which
//! answers must pass, and which must not.

use canvass_analyzer::NodeId;
use canvass_device::models::Model;
use canvass_fuzzer::reproducer::replay;
use canvass_fuzzer::{Knowledge, Property, Violation};

const EDS: &str = include_str!("../../../device/models/reference-301.eds");
const SHEET: &str = include_str!("../../../device/models/reference-301.toml");

fn violation(bus: &str, log: &str) -> Option<Violation> {
    replay(bus, NodeId::new(10), None, log.as_bytes()).unwrap()
}

/// A block download to 1017h:00 that announces two bytes, has one, and ends with a wrong CRC.
const SHORT: &str = "\
(0000000000.000000) can0 60A#C617100002000000
(0000000000.100000) can0 60A#8101000000000000
(0000000000.200000) can0 60A#D9FFFF0000000000
";

/// A block download to 1017h:00 that announces two bytes, has three, and ends with a wrong CRC.
const LONG: &str = "\
(0000000000.000000) can0 60A#C617100002000000
(0000000000.100000) can0 60A#8101020300000000
(0000000000.200000) can0 60A#D1FFFF0000000000
";

#[test]
fn a_wrong_crc_and_a_wrong_length_at_once_are_refused_for_either_reason() {
    for log in [SHORT, LONG] {
        for bus in
            ["sim:reference-301", "sim:reference-301~~length-before-crc", "sim:reference-301~~length-code-general"]
        {
            assert!(violation(bus, log).is_none(), "{bus}: {:#?}", violation(bus, log));
        }
        let wrong = violation("sim:reference-301+sdo-block-size-mismatch-accepted+sdo-block-crc-ignored", log).unwrap();
        assert_eq!(wrong.property, Property::LegalSdo);
    }
}

/// Sub-index 4 of 1800h does not exist, even if a description contains it. The case `301/pdo/reserved-entry` agrees.
#[test]
fn a_reserved_entry_that_is_described_is_none() {
    let (before, after) = EDS.split_once("[1800sub5]").unwrap();
    let sub = "[1800sub4]\nParameterName=reserved\nObjectType=0x7\nDataType=0x0005\nAccessType=rw\nDefaultValue=0\n\n";
    let model = Model::read(&format!("{before}{sub}[1800sub5]{after}"), SHEET).unwrap();
    let knowledge = Knowledge::new(NodeId::MIN, Some(model.description()), Some(model.sheet()));
    let reserved = canvass_analyzer::Multiplexer::new(0x1800, 4);
    assert!(model.description().dictionary.entry(reserved).is_ok());
    assert!(knowledge.entry(reserved).is_none() && knowledge.has_index(reserved));
}

/// 2105h of these devices stores node-ID and bit rate, and they are silent for 14 ms meanwhile, as after 1010h.
#[test]
fn a_device_may_be_silent_while_it_stores_by_an_object_of_its_own() {
    for model in ["kuebler-sendix-58x8", "kuebler-sendix-f58", "kuebler-sendix-f58m", "kuebler-sendix-m58"] {
        let log = "(0000000000.000000) can0 605#2305210073617665\n(0000000000.005000) can0 605#4000100000000000\n";
        let bus = format!("sim:{model}");
        let judged = replay(&bus, NodeId::new(5), None, log.as_bytes()).unwrap();
        assert!(judged.is_none(), "{model}: {judged:#?}");
    }
}
