//! Prior knowledge of devices: descriptions, and models that are recognised.

use crate::trace::Trace;
use crate::{events, node};
use canvass_analyzer::dictionary::{BitName, DeviceDescription, KnownDevice};
use canvass_analyzer::network::{Candidate, Candidates, Event, Fact, Move, Source, Use};
use canvass_analyzer::{Multiplexer, NodeId, PdoNumber};
use canvass_traces::ChannelId;
use std::sync::Arc;

/// A description of some objects of 32 bits each: index, sub-index, value.
fn device(objects: &[(u16, u8, &str)]) -> KnownDevice {
    let mut eds = "[DeviceInfo]\nVendorName=x\n".to_owned();
    for (index, sub, value) in objects {
        let entry = format!("ParameterName=x\nObjectType=7\nDataType=7\nAccessType=rw\nDefaultValue={value}\n");
        eds += &match sub {
            0 => format!("[{index:04X}]\n{entry}"),
            _ => format!("[{index:04X}]\nParameterName=x\nObjectType=9\nSubNumber=2\n[{index:04X}sub{sub:X}]\n{entry}"),
        };
    }
    KnownDevice::described(DeviceDescription::read(eds.as_bytes()).unwrap())
}

/// The COB-IDs of a description: PDOs and EMCY leave their default CAN-ID. SYNC and TIME may be on both CAN-IDs,
/// because another device may use the default one.
#[test]
fn a_description_moves_what_is_the_nodes_own() {
    let mut trace = Trace::new();
    let known = device(&[
        (0x1005, 0, "0x90"),
        (0x1012, 0, "0x111"),
        (0x1014, 0, "0xB5"),
        (0x1401, 1, "$NODEID+0x40000395"),
        (0x1800, 1, "0x18A"),
        (0x1801, 1, "0x80000285"),
        (0x1804, 1, "0x195"),
    ]);
    trace.network.describe(node(5), known);
    let about = |trace: &mut Trace, frame: &str| {
        let said = trace.say(frame);
        (said.service(), said.decoded.node.map(NodeId::raw), said.decoded.source)
    };
    use Source::{Description, Predefined};
    assert_eq!(about(&mut trace, "090#"), ("sync", None, Description));
    assert_eq!(about(&mut trace, "080#"), ("sync", None, Predefined));
    assert_eq!(about(&mut trace, "111#00 00 00 00 00 00"), ("time", None, Description));
    assert_eq!(about(&mut trace, "100#00 00 00 00 00 00"), ("time", None, Predefined));
    assert_eq!(about(&mut trace, "0B5#30 81 11 00 00 00 00 00"), ("emcy", Some(5), Description));
    assert_eq!(about(&mut trace, "085#30 81 11 00 00 00 00 00").0, "unknown");
    assert_eq!(about(&mut trace, "18A#00"), ("pdo", Some(5), Description));
    assert_eq!(about(&mut trace, "185#00").0, "unknown");
    assert_eq!(about(&mut trace, "39A#00"), ("pdo", Some(5), Description));
    assert_eq!(about(&mut trace, "195#00"), ("pdo", Some(5), Description));
    // The PDO is switched off in the description, but may have been switched on before the capture.
    assert_eq!(about(&mut trace, "285#00"), ("pdo", Some(5), Predefined));
    // The trace overrides a description, even one that comes later.
    trace.say("605#23 00 18 01 0C 01 00 40");
    trace.say("585#60 00 18 01 00 00 00 00");
    trace.network.describe(node(5), device(&[(0x1800, 1, "0x18B")]));
    assert_eq!(about(&mut trace, "10C#00"), ("pdo", Some(5), Source::Trace));
}

fn offering() -> Trace {
    let known = device(&[(0x1800, 1, "0x18A"), (0x1804, 1, "0x195")]);
    let mut candidate = Candidate::of("model", Arc::new(known));
    // The facts are not in the order of the objects.
    candidate.set(Multiplexer::new(0x1018, 2), Fact::Number(vec![7]));
    candidate.set(Multiplexer::new(0x1018, 1), Fact::Number(vec![0x13]));
    let mut trace = Trace::new();
    trace.network.offer(Candidates::new(move || [candidate].into()));
    trace
}

/// Once the model is recognised, the CAN-IDs of the node's PDOs are known.
#[test]
fn a_recognised_node_has_the_places_of_its_model() {
    let mut trace = offering();
    for frame in ["605#40 18 10 01 00 00 00 00", "585#43 18 10 01 13 00 00 00", "605#40 18 10 02 00 00 00 00"] {
        trace.say(frame);
    }
    let moved = |number, from, to| {
        let used = Use::Pdo(node(5), PdoNumber::Transmit(number));
        Event::CobIdMoved(Move { used, from, to: Some(to), source: Source::Description })
    };
    let all = events(&mut trace, "585#43 18 10 02 07 00 00 00");
    let expected =
        [Event::TransferEnded, Event::Recognised(node(5)), moved(1, Some(0x185), 0x18A), moved(5, None, 0x195)];
    assert_eq!(all, expected);
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    let by = &bus.node(node(5)).unwrap().recognition.as_ref().unwrap().by;
    assert_eq!(by, &[Multiplexer::new(0x1018, 1), Multiplexer::new(0x1018, 2)]);
    // A repeated read causes no event.
    trace.say("605#40 18 10 01 00 00 00 00");
    assert_eq!(events(&mut trace, "585#43 18 10 01 13 00 00 00"), [Event::TransferEnded]);
}

/// A value that a master writes identifies no device.
#[test]
fn nothing_is_recognised_by_what_is_written() {
    let mut trace = offering();
    for frame in [
        "605#23 18 10 01 13 00 00 00",
        "585#60 18 10 01 00 00 00 00",
        "605#23 18 10 02 07 00 00 00",
        "585#60 18 10 02 00 00 00 00",
    ] {
        assert!(!events(&mut trace, frame).contains(&Event::Recognised(node(5))), "{frame}");
    }
    assert_eq!(trace.say("18A#00").decoded.node, Some(node(10)));
}

/// An annotation of 6000h names the bit that decides the unit of speeds.
#[test]
fn a_description_may_name_the_unit_of_speeds() {
    let bit =
        BitName { bit: 12, name: "Speed format: units per second".into(), clear: Some("Speed format: rpm".into()) };
    for (bit, operating, unit) in [
        (bit.clone(), 0x1000, "steps/s"),
        (bit.clone(), 0x0000, "rpm"),
        (bit.clone(), 0xEFFF, "rpm"),
        (BitName { name: "Speed format: mm/s".into(), ..bit.clone() }, 0x1000, "mm/s"),
        (BitName { name: "Other: mm/s".into(), ..bit.clone() }, 0x1000, ""),
        // 6000h has no more than 32 bits.
        (BitName { bit: 40, ..bit.clone() }, 0x0001, "rpm"),
        (BitName { clear: None, ..bit }, 0, ""),
    ] {
        let mut known = device(&[(0x1000, 0, "0x00020196")]);
        known.manual.annotations.entry(Multiplexer::new(0x6000, 0)).bits.push(bit.clone());
        let mut trace = Trace::new();
        trace.network.describe(node(5), known);
        let [low, high] = u16::to_le_bytes(operating);
        trace.say("605#40 00 60 00 00 00 00 00");
        trace.say(&format!("585#4B 00 60 00 {low:02X} {high:02X} 00 00"));
        trace.say("605#40 30 60 01 00 00 00 00");
        let text = trace.say("585#4B 30 60 01 F6 FF 00 00").text;
        let expected = if unit.is_empty() { "= -10".to_owned() } else { format!("= -10 {unit}") };
        assert!(text.ends_with(&expected), "{bit:?} {operating:04X}: {text}");
    }
}

/// A description may be added while the capture runs.
#[test]
fn a_description_counts_on_buses_that_are_known() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("18A#00").decoded.node, Some(node(10)));
    trace.network.describe(node(5), device(&[(0x1800, 1, "0x18A")]));
    assert_eq!(trace.say("18A#00").decoded.node, Some(node(5)));
}

/// A model needs vendor-ID and product code, or device type and name. One of the two values is not enough.
#[test]
fn half_an_identity_fits_nothing() {
    let mut candidate = Candidate::of("model", Arc::new(device(&[(0x1000, 0, "0x00020196")])));
    candidate.set(Multiplexer::new(0x1008, 0), Fact::Begins("Send".to_owned()));
    candidate.set(Multiplexer::new(0x1018, 1), Fact::Number(vec![0x13]));
    candidate.set(Multiplexer::new(0x1018, 2), Fact::Number(vec![7]));
    let candidates = Candidates::new(move || [candidate].into());
    let facts: [(u16, u8, &[u8]); 4] = [
        (0x1000, 0, &[0x96, 1, 2, 0]),
        (0x1008, 0, b"Sendix"),
        (0x1018, 1, &[0x13, 0, 0, 0]),
        (0x1018, 2, &[7, 0, 0, 0]),
    ];
    for shown in 0_u8..16 {
        let known = facts.iter().enumerate().filter(|(n, _)| shown >> n & 1 != 0);
        let known = known.map(|(_, &(index, sub, data))| (Multiplexer::new(index, sub), data.to_vec())).collect();
        let fits = shown & 0b0011 == 0b0011 || shown & 0b1100 == 0b1100;
        assert_eq!(candidates.fitting(&known).len(), usize::from(fits), "{shown:04b}");
    }
}

/// 6031h:03 multiplies and 6031h:04 divides; neither may be 0, and a speed in rpm has neither (CiA 406).
#[test]
fn speeds_have_a_multiplier_and_a_divisor() {
    for (vendor, multiplier, divisor, text) in [
        (0x14, 2, 5, "= -25 steps/s"),
        (0x14, 1, 1, "= -10 steps/s"),
        (0x14, 1, 5, "= -50 steps/s"),
        (0x14, 2, 1, "= -5 steps/s"),
        (0x14, 0, 5, "= -10"),
        (0x14, 2, 0, "= -10"),
        // For Kübler's encoders a bit of 6000h determines the unit.
        (0x13, 2, 5, "= -10 rpm"),
    ] {
        let mut trace = Trace::new();
        let mut shown = |object: &str, value: u32| {
            let [a, b, c, d] = value.to_le_bytes();
            trace.say(&format!("605#40 {object} 00 00 00 00"));
            trace.say(&format!("585#43 {object} {a:02X} {b:02X} {c:02X} {d:02X}"));
        };
        shown("00 10 00", 0x0002_0196);
        shown("18 10 01", vendor);
        shown("07 65 00", 0x0102_0302);
        shown("00 60 00", 0);
        shown("31 60 03", multiplier);
        shown("31 60 04", divisor);
        trace.say("605#40 30 60 01 00 00 00 00");
        let said = trace.say("585#4B 30 60 01 F6 FF 00 00").text;
        assert!(said.ends_with(text), "{vendor:X} {multiplier}/{divisor}: {said}");
    }
}
