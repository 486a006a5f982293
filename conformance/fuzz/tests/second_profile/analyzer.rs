//! The object names of the profile, and the meaning of an EMCY code.

use super::{INPUTS, NUMBER, OUTPUTS, OVERLOAD, model, node};
use canvass_analyzer::EmcyText;
use canvass_analyzer::dictionary::names::{self, Profile, Registered, StandardEntry, StandardObject};
use canvass_analyzer::dictionary::{Access, DataType, ObjectCode};
use canvass_analyzer::network::Network;
use canvass_analyzer::wire::emcy::{Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::{Index, Multiplexer};
use canvass_traces::{ChannelId, Record, Timestamp, parse_frame};

struct DigitalIo;

inventory::submit! { Registered(&DigitalIo) }

const fn entry(first: u8, last: u8, name: &'static str, access: Access) -> StandardEntry {
    StandardEntry { first, last, name, data_type: Some(DataType::UNSIGNED8), access: Some(access) }
}

const fn array(index: u16, name: &'static str, entries: &'static [StandardEntry]) -> StandardObject {
    StandardObject { first: index, last: index, standard: "CiA 401", name, code: ObjectCode::ARRAY, entries }
}

const COUNT: StandardEntry = entry(0, 0, "Highest sub-index supported", Access::Ro);

static OBJECTS: [StandardObject; 2] = [
    array(INPUTS.index.0, "Read input 8-bit", &[COUNT, entry(1, 254, "Digital inputs", Access::Ro)]),
    array(OUTPUTS.index.0, "Write output 8-bit", &[COUNT, entry(1, 254, "Digital outputs", Access::Rw)]),
];

impl Profile for DigitalIo {
    fn number(&self) -> u16 {
        NUMBER
    }

    fn standard(&self) -> &'static str {
        "CiA 401"
    }

    fn objects(&self) -> &'static [StandardObject] {
        &OBJECTS
    }

    fn bits(&self, index: Index) -> &'static [&'static str] {
        if index == INPUTS.index { &["input 1", "input 2", "input 3"] } else { &[] }
    }

    fn emergency(&self, code: EmcyCode) -> Option<&'static str> {
        (code.0 == OVERLOAD).then_some("overload of the digital outputs")
    }
}

#[test]
fn objects_have_the_names_of_their_profile() {
    let name = |at: Multiplexer, profile| names::object_name(at, Some(profile)).map(|name| name.to_string());
    assert_eq!(name(INPUTS, NUMBER).as_deref(), Some("Read input 8-bit, Digital inputs 1"));
    assert_eq!(names::bit_name(INPUTS.index, 1, Some(NUMBER)), Some("input 2"));
    // The same index names another object in another profile.
    let other = names::profiles().find(|profile| profile.number() != NUMBER).unwrap().number();
    assert_ne!(name(INPUTS, other), name(INPUTS, NUMBER));
}

#[test]
fn an_error_code_of_the_profile_has_its_meaning() {
    let mut network = Network::new();
    network.describe(node(), model("io").device().as_ref().clone());
    let frame = parse_frame("709#00").unwrap().frame;
    network.handle(&Record::new(Timestamp::ZERO, ChannelId(0), frame));
    let bus = network.bus(ChannelId(0)).unwrap();
    let text = |code| EmcyText::of(&Emcy::new(EmcyCode(code), ErrorRegister(0x03), [0; 5]), node(), bus).to_string();
    assert!(text(OVERLOAD).starts_with("2320h overload of the digital outputs, register"), "{}", text(OVERLOAD));
    assert!(!text(0x2310).contains("overload"));
}
