//! Dialogues of LMT, and what is known of devices before the capture: descriptions, recognition, LSS addresses.

use crate::trace::Trace;
use canvass_analyzer::dictionary::{BitName, DeviceDescription, KnownDevice};
use canvass_analyzer::network::{Candidate, Candidates, Event, Exchange, Fact, Move, Source, Use};
use canvass_analyzer::{Multiplexer, NodeId, PdoNumber};
use canvass_traces::{ChannelId, Duration, Timestamp};
use std::sync::Arc;

fn node(raw: u8) -> NodeId {
    NodeId::new(raw).unwrap()
}

fn events(trace: &mut Trace, frame: &str) -> Vec<Event> {
    trace.say(frame);
    trace.network.bus(ChannelId(0)).unwrap().events().to_vec()
}

/// A description of some objects, each of 32 bits: index, sub-index, value.
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

/// Each service of LMT that has an answer is missed when the next request comes first (CiA 205-2).
#[test]
fn lmt_requests_have_answers() {
    let asked = |unanswered| Event::LayerSetting(Exchange::Request { unanswered });
    for (request, answered) in [
        ("7E5#11 05 00 00 00 00 00 00", true),
        ("7E5#13 00 03 00 00 00 00 00", true),
        ("7E5#17 00 00 00 00 00 00 00", true),
        ("7E5#24 00 00 00 00 00 00 00", true),
        ("7E5#04 01 00 00 00 00 00 00", false),
        ("7E5#01 41 42 43 20 20 20 20", false),
    ] {
        let mut trace = Trace::new();
        // LMT's own way to ask for the manufacturer name.
        trace.say("7E5#24 00 00 00 00 00 00 00");
        trace.say("7E4#24 41 42 43 20 20 20 20");
        assert_eq!(events(&mut trace, request), [asked(false)], "{request}");
        assert_eq!(events(&mut trace, request), [asked(answered)], "{request}");
        let answer = Event::LayerSetting(Exchange::Response(Duration::from_millis(1)));
        assert_eq!(events(&mut trace, "7E4#17 00 00 00 00 00 00 00"), [answer], "{request}");
    }
}

/// Table 0 of LMT: code 3 is 250 kbit/s, code 7 is 20 kbit/s. It acts when it was confirmed.
#[test]
fn lmt_sets_bit_rates_and_addresses() {
    let activated = |setting: &str, answer: Option<&str>| {
        let mut trace = Trace::new();
        trace.say("7E5#24 00 00 00 00 00 00 00");
        trace.say(setting);
        answer.into_iter().for_each(|answer| drop(trace.say(answer)));
        let all = events(&mut trace, "7E5#15 E8 03 00 00 00 00 00");
        all.into_iter().find(|event| matches!(event, Event::BitRateChanged { .. })).unwrap()
    };
    let changed = |bit_rate| Event::BitRateChanged { node: None, bit_rate, delay: Duration::from_millis(1_000) };
    let (good, bad) = ("7E4#13 00 00 00 00 00 00 00", "7E4#13 01 00 00 00 00 00 00");
    assert_eq!(activated("7E5#13 00 03 00 00 00 00 00", Some(good)), changed(Some(250_000)));
    assert_eq!(activated("7E5#13 00 03 00 00 00 00 00", Some(bad)), changed(None));
    assert_eq!(activated("7E5#13 00 03 00 00 00 00 00", None), changed(None));
    assert_eq!(activated("7E5#13 80 03 00 00 00 00 00", Some(good)), changed(None));

    for (answer, given) in [("7E4#11 00 00 00 00 00 00 00", true), ("7E4#11 01 00 00 00 00 00 00", false)] {
        let mut trace = Trace::new();
        trace.say("7E5#24 00 00 00 00 00 00 00");
        trace.say("7E5#11 07 00 00 00 00 00 00");
        trace.say(answer);
        let changed = Event::NodeIdChanged { from: None, to: node(7), object: None };
        assert_eq!(events(&mut trace, "707#00").contains(&changed), given, "{answer}");
    }
    // Another slave is switched to: what was asked of the one before is not confirmed by it.
    for switch in ["7E5#04 00 00 00 00 00 00 00", "7E5#01 41 42 43 20 20 20 20"] {
        let mut trace = Trace::new();
        trace.say("7E5#24 00 00 00 00 00 00 00");
        trace.say("7E5#11 07 00 00 00 00 00 00");
        trace.say(switch);
        trace.say("7E4#11 00 00 00 00 00 00 00");
        assert_eq!(events(&mut trace, "707#00").len(), 1, "{switch}");
    }
}

/// Only a node that has shown all four numbers of the address is the one that was addressed.
#[test]
fn a_part_of_an_lss_address_is_too_few() {
    for (shown, found) in
        [([0x13, 0xF1, 0x66, 0xA5], true), ([0x13, 0xF1, 0x66, 0xA6], false), ([0x14, 0xF1, 0x66, 0xA5], false)]
    {
        let mut trace = Trace::new();
        for (sub, value) in (1..).zip(shown) {
            trace.say(&format!("63F#40 18 10 0{sub} 00 00 00 00"));
            trace.say(&format!("5BF#43 18 10 0{sub} {value:02X} 00 00 00"));
        }
        for (command, value) in (0x40..).zip([0x13, 0xF1, 0x66, 0xA5]) {
            trace.say(&format!("7E5#{command:02X} {value:02X} 00 00 00 00 00 00"));
        }
        trace.say("7E4#44 00 00 00 00 00 00 00");
        trace.say("7E5#11 2A 00 00 00 00 00 00");
        trace.say("7E4#11 00 00 00 00 00 00 00");
        let changed = Event::NodeIdChanged { from: found.then(|| node(63)), to: node(42), object: None };
        assert!(events(&mut trace, "72A#00").contains(&changed), "{shown:02X?}");
    }
    // A node that was given the node-ID that it had is no news.
    let mut trace = Trace::new();
    trace.say("7E5#5E 00 00 00 00 00 00 00");
    trace.say("7E4#5E 2A 00 00 00 00 00 00");
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    assert_eq!(events(&mut trace, "72A#00").len(), 1);
}

/// A message that is too short for a code is no end of an error.
#[test]
fn a_cut_emcy_ends_no_error() {
    let mut trace = Trace::new();
    let since = |trace: &mut Trace, frame: &str| match events(trace, frame)[..] {
        [Event::Emergency(_, emergency)] => emergency.since.map(|at| at - Timestamp(1_000_000_000)),
        ref other => panic!("{other:?}"),
    };
    assert_eq!(since(&mut trace, "085#30 81 11 00 00 00 00 00"), Some(Duration::from_millis(1)));
    assert_eq!(since(&mut trace, "085#30"), Some(Duration::from_millis(1)));
    assert_eq!(since(&mut trace, "085#00 10"), Some(Duration::from_millis(1)));
    assert_eq!(since(&mut trace, "085#00 00"), Some(Duration::from_millis(1)));
    assert_eq!(since(&mut trace, "085#00 00"), None);
}

/// What a description says of CAN-IDs: PDOs and EMCY leave their place for it, SYNC and TIME may be at both, because another
/// device may say otherwise.
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
    // Switched off as delivered: but it may have been switched on before the capture.
    assert_eq!(about(&mut trace, "285#00"), ("pdo", Some(5), Predefined));
    // The trace knows better, also than a description that comes later.
    trace.say("605#23 00 18 01 0C 01 00 40");
    trace.say("585#60 00 18 01 00 00 00 00");
    trace.network.describe(node(5), device(&[(0x1800, 1, "0x18B")]));
    assert_eq!(about(&mut trace, "10C#00"), ("pdo", Some(5), Source::Trace));
}

/// A PDO that was there at the start, was switched off, and comes back with the next start.
#[test]
fn a_start_brings_back_what_was_switched_off() {
    let mut trace = Trace::new();
    trace.say("605#40 04 18 01 00 00 00 00");
    trace.say("585#43 04 18 01 95 01 00 40");
    trace.say("605#23 04 18 01 95 01 00 C0");
    trace.say("585#60 04 18 01 00 00 00 00");
    assert_eq!(trace.say("195#00").decoded.node, Some(node(0x15)));
    let used = Use::Pdo(node(5), PdoNumber::Transmit(5));
    let back = Event::CobIdMoved(Move { used, from: None, to: Some(0x195), source: Source::Trace });
    let started = events(&mut trace, "705#00");
    assert_eq!(started.iter().filter(|event| **event == back).count(), 1, "{started:?}");
}

/// The mapping that a start takes back is told once, however many entries it has.
#[test]
fn a_mapping_is_told_once() {
    let mut trace = Trace::new();
    for (sub, value) in [("01", "08 00 00 21"), ("02", "08 00 01 21"), ("00", "02 00 00 00")] {
        trace.say(&format!("605#23 00 1A {sub} {value}"));
        trace.say(&format!("585#60 00 1A {sub} 00 00 00 00"));
    }
    let changed = Event::MappingChanged(node(5), PdoNumber::Transmit(1));
    let started = events(&mut trace, "705#00");
    assert_eq!(started.iter().filter(|event| **event == changed).count(), 1, "{started:?}");
}

fn offering() -> Trace {
    let known = device(&[(0x1800, 1, "0x18A"), (0x1804, 1, "0x195")]);
    let mut candidate = Candidate::of("model", Arc::new(known));
    // In another order than that of the objects.
    candidate.set(Multiplexer::new(0x1018, 2), Fact::Number(vec![7]));
    candidate.set(Multiplexer::new(0x1018, 1), Fact::Number(vec![0x13]));
    let mut trace = Trace::new();
    trace.network.offer(Candidates::new(move || [candidate].into()));
    trace
}

/// With its model the places of a node's PDOs are known.
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
    // Shown again, it is no news.
    trace.say("605#40 18 10 01 00 00 00 00");
    assert_eq!(events(&mut trace, "585#43 18 10 01 13 00 00 00"), [Event::TransferEnded]);
}

/// What a master writes is not what a device shows of itself.
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

/// 128 entries are 64 objects with their twins; more are none.
#[test]
fn an_srdo_maps_up_to_64_objects() {
    for (count, length) in [(0, None), (2, Some(1)), (127, Some(8)), (128, Some(8)), (129, None)] {
        let mut trace = Trace::new();
        let mut show = |object: &str, value: &str| {
            trace.say(&format!("605#40 {object} 00 00 00 00"));
            trace.say(&format!("585#43 {object} {value}"));
        };
        show("01 13 05", "41 01 00 00");
        for sub in (1..=129).step_by(2) {
            show(&format!("81 13 {sub:02X}"), "01 00 00 21");
        }
        show("81 13 00", &format!("{count:02X} 00 00 00"));
        trace.say("141#00 00 00 00 00 00 00 00");
        let node = trace.network.bus(ChannelId(0)).unwrap().node(node(5)).unwrap();
        assert_eq!(node.known_srdo_layout(1).map(|layout| layout.length()), length, "{count}");
    }
}

/// Multiplexed PDOs that are too short are told, and their place is believed all the same: any bytes may be a PDO.
#[test]
fn short_multiplexed_pdos_disprove_nothing() {
    let mut trace = Trace::new();
    for (object, value) in [("00 18 01", "0A 01 00 40"), ("00 1A 00", "FF 00 00 00")] {
        trace.say(&format!("605#23 {object} {value}"));
        trace.say(&format!("585#60 {object} 00 00 00 00"));
    }
    for _ in 0..150 {
        assert_eq!(trace.say("10A#85").service(), "pdo");
    }
}

/// An address that was selected before another slave was switched to is not that slave's.
#[test]
fn an_lss_address_belongs_to_the_slave_that_was_selected() {
    let mut trace = Trace::new();
    for (sub, value) in (1..).zip(["13", "F1", "66", "A5"]) {
        trace.say(&format!("63F#40 18 10 0{sub} 00 00 00 00"));
        trace.say(&format!("5BF#43 18 10 0{sub} {value} 00 00 00"));
    }
    for (command, value) in (0x40..).zip(["13", "F1", "66", "A5"]) {
        trace.say(&format!("7E5#{command:02X} {value} 00 00 00 00 00 00"));
    }
    trace.say("7E5#04 00 00 00 00 00 00 00");
    trace.say("7E5#04 01 00 00 00 00 00 00");
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    let changed = Event::NodeIdChanged { from: None, to: node(42), object: None };
    assert!(events(&mut trace, "72A#00").contains(&changed));
}

/// SYNC and TIME move each by itself.
#[test]
fn sync_is_not_taken_for_time() {
    let mut trace = Trace::new();
    let mut moved = |index: &str, id: &str| {
        trace.say(&format!("605#23 {index} 10 00 {id} 00 00 00"));
        let all = events(&mut trace, &format!("585#60 {index} 10 00 00 00 00 00"));
        all.into_iter().find_map(|event| match event {
            Event::CobIdMoved(moved) => Some((moved.used, moved.from, moved.to)),
            _ => None,
        })
    };
    assert_eq!(moved("05", "95"), Some((Use::Sync, Some(0x80), Some(0x95))));
    assert_eq!(moved("12", "91"), Some((Use::Time, Some(0x100), Some(0x91))));
    assert_eq!(moved("05", "99"), Some((Use::Sync, Some(0x95), Some(0x99))));
    assert_eq!(moved("12", "97"), Some((Use::Time, Some(0x91), Some(0x97))));
}

/// Switched off, a COB-ID may hold any CAN-ID, also one that is restricted.
#[test]
fn what_is_switched_off_may_have_no_can_id() {
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 00 00 00 80");
    let used = Use::Pdo(node(5), PdoNumber::Transmit(1));
    let gone = Event::CobIdMoved(Move { used, from: Some(0x185), to: None, source: Source::Trace });
    assert!(events(&mut trace, "585#60 00 18 01 00 00 00 00").contains(&gone));
}

/// Values of the application are no parameters: they are not kept.
#[test]
fn process_values_are_not_kept() {
    let mut trace = Trace::new();
    for object in ["04 60 00", "17 10 00", "00 20 00"] {
        trace.say(&format!("605#40 {object} 00 00 00 00"));
        trace.say(&format!("585#43 {object} 01 00 00 00"));
    }
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    let kept: Vec<_> = bus.node(node(5)).unwrap().parameters().collect();
    assert_eq!(kept, [(Multiplexer::new(0x1017, 0), 1)]);
}

/// A description may come while the capture runs.
#[test]
fn a_description_counts_on_buses_that_are_known() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("18A#00").decoded.node, Some(node(10)));
    trace.network.describe(node(5), device(&[(0x1800, 1, "0x18A")]));
    assert_eq!(trace.say("18A#00").decoded.node, Some(node(5)));
}

/// Vendor and product, or device type and name: one of two is too few.
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
        // Of Kübler's encoders 6000h says it.
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
