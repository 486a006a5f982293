//! The CAN-IDs of services on a bus, and values that are no parameters of a node.

use crate::trace::Trace;
use crate::{events, node};
use canvass_analyzer::network::{Event, Move, Source, Use};
use canvass_analyzer::{Multiplexer, PdoNumber};
use canvass_traces::{ChannelId, Duration, Timestamp};

/// An EMCY that is too short for an error code ends no error.
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

/// The CAN-IDs of SYNC and TIME move independently.
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

/// A COB-ID that is switched off may hold any CAN-ID, even a restricted one.
#[test]
fn what_is_switched_off_may_have_no_can_id() {
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 00 00 00 80");
    let used = Use::Pdo(node(5), PdoNumber::Transmit(1));
    let gone = Event::CobIdMoved(Move { used, from: Some(0x185), to: None, source: Source::Trace });
    assert!(events(&mut trace, "585#60 00 18 01 00 00 00 00").contains(&gone));
}

/// Values of the application are no parameters, so they are not kept.
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

/// A PDO exists at the start, is switched off, and returns with the next start.
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

/// A mapping that a start changes back is one event, however many entries it has.
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

/// 128 entries are 64 objects with their twins. A higher count is invalid.
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

/// Multiplexed PDOs that are too short are reported, but do not disprove the use of the CAN-ID, as any bytes may be a
/// PDO.
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
