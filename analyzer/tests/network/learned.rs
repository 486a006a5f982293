//! The facts that the network learns from SDO traffic, and the facts that it forgets at a boot-up (CiA 301, 7.3.2.2.1).

use crate::trace::Trace;
use crate::{events, node};
use canvass_analyzer::network::{Event, Move, Source, Use};
use canvass_analyzer::{PdoNumber, Service};
use canvass_traces::ChannelId;

/// Node 5 accepts a download of four bytes. Returns the events.
fn written(trace: &mut Trace, object: &str, value: &str) -> Vec<Event> {
    trace.say(&format!("605#23 {object} {value}"));
    let mut all = events(trace, &format!("585#60 {object} 00 00 00 00"));
    all.retain(|event| *event != Event::TransferEnded);
    all
}

/// Node 5 answers an upload with four bytes. Returns the events.
fn read(trace: &mut Trace, object: &str, value: &str) -> Vec<Event> {
    trace.say(&format!("605#40 {object} 00 00 00 00"));
    let mut all = events(trace, &format!("585#43 {object} {value}"));
    all.retain(|event| *event != Event::TransferEnded);
    all
}

fn moved(used: Use, from: Option<u16>, to: Option<u16>) -> Event {
    Event::CobIdMoved(Move { used, from, to, source: Source::Trace })
}

#[test]
fn every_service_moves_by_its_object() {
    let cases = [
        ("14 10 00", "B0 00 00 00", Use::Emcy(node(5)), 0x085, 0x0B0),
        ("05 10 00", "90 00 00 00", Use::Sync, 0x080, 0x090),
        ("12 10 00", "11 01 00 00", Use::Time, 0x100, 0x111),
        ("00 14 01", "0A 02 00 00", Use::Pdo(node(5), PdoNumber::Receive(1)), 0x205, 0x20A),
        ("01 14 01", "0A 03 00 00", Use::Pdo(node(5), PdoNumber::Receive(2)), 0x305, 0x30A),
        ("01 18 01", "8A 02 00 40", Use::Pdo(node(5), PdoNumber::Transmit(2)), 0x285, 0x28A),
    ];
    for (object, value, used, from, to) in cases {
        let mut trace = Trace::new();
        assert_eq!(written(&mut trace, object, value), [moved(used, Some(from), Some(to))], "{object}");
        assert_eq!(written(&mut trace, object, value), [], "{object}");
    }
}

#[test]
fn what_has_no_place_in_the_standard_is_new_there() {
    let mut trace = Trace::new();
    let ninth = Use::Pdo(node(5), PdoNumber::Transmit(9));
    assert_eq!(written(&mut trace, "08 18 01", "95 01 00 40"), [moved(ninth, None, Some(0x195))]);
    assert_eq!(trace.say("195#01 02").text, "TPDO 9, 2 bytes, mapping not known");
    assert_eq!(written(&mut trace, "08 18 01", "95 01 00 C0"), [moved(ninth, Some(0x195), None)]);
}

/// CAN-IDs that CiA 301 (7.3.5) restricts are not learned, and 29-bit CAN-IDs are not looked up among the 11-bit ones.
#[test]
fn impossible_places_are_not_taken() {
    let mut trace = Trace::new();
    let first = Use::Pdo(node(5), PdoNumber::Transmit(1));
    assert_eq!(written(&mut trace, "00 18 01", "01 07 00 40"), [], "701h is error control");
    assert_eq!(written(&mut trace, "00 18 01", "85 01 00 60"), [moved(first, Some(0x185), None)], "29 bits");
}

#[test]
fn the_first_sdo_server_stays_where_it_is_unless_it_was_told_to_move() {
    let mut trace = Trace::new();
    assert_eq!(read(&mut trace, "00 12 01", "0A 06 00 00"), []);
    assert_eq!(trace.say("60A#40 18 10 01 00 00 00 00").decoded.node, Some(node(10)));
}

/// 1200h is read-only. A device that accepts another COB-ID there may use the new CAN-ID or its default one.
#[test]
fn a_first_sdo_server_that_was_told_to_move_is_known_in_both_places() {
    let mut trace = Trace::new();
    written(&mut trace, "00 12 01", "A0 06 00 00");
    written(&mut trace, "00 12 02", "A1 06 00 00");
    for (request, response) in [("605", "585"), ("6A0", "6A1")] {
        let asked = trace.say(&format!("{request}#40 18 10 01 00 00 00 00"));
        assert_eq!((asked.decoded.node, asked.decoded.service), (Some(node(5)), Service::Sdo));
        let answered = trace.say(&format!("{response}#43 18 10 01 2A 00 00 00"));
        assert!(answered.decoded.ends_transfer() && answered.decoded.violation.is_none(), "{request}");
    }
}

/// COB-IDs and mappings that were not stored are lost at the next start: the former ones return.
#[test]
fn a_boot_up_takes_back_what_was_not_stored() {
    let mut trace = Trace::new();
    let first = Use::Pdo(node(5), PdoNumber::Transmit(1));
    written(&mut trace, "00 18 01", "0A 01 00 40");
    trace.say("605#2F 00 1A 00 01 00 00 00");
    trace.say("585#60 00 1A 00 00 00 00 00");
    let mapping = written(&mut trace, "00 1A 01", "20 00 04 60");
    assert_eq!(mapping, [Event::MappingChanged(node(5), PdoNumber::Transmit(1))]);
    assert_eq!(trace.say("10A#01 02 03 04").text, "TPDO 1: 6004h:00 = 04030201h");
    let back = events(&mut trace, "705#00");
    let back_home =
        Event::CobIdMoved(Move { used: first, from: Some(0x10A), to: Some(0x185), source: Source::Predefined });
    assert!(back.contains(&back_home), "{back:?}");
    assert!(back.contains(&Event::MappingChanged(node(5), PdoNumber::Transmit(1))), "{back:?}");
    assert_eq!(trace.say("185#01 02 03 04").text, "TPDO 1, 4 bytes, mapping not known");
}

/// 1010h:01 stores the COB-ID.
#[test]
fn a_boot_up_keeps_what_was_stored() {
    let mut trace = Trace::new();
    written(&mut trace, "00 18 01", "0A 01 00 40");
    trace.say("605#23 10 10 01 73 61 76 65");
    trace.say("585#60 10 10 01 00 00 00 00");
    let back = events(&mut trace, "705#00");
    assert!(!back.iter().any(|event| matches!(event, Event::CobIdMoved(_))), "{back:?}");
    assert_eq!(trace.say("10A#01").decoded.node, Some(node(5)));
}

#[test]
fn a_boot_up_ends_the_transfers_of_the_node() {
    let mut trace = Trace::new();
    trace.say("605#40 08 10 00 00 00 00 00");
    trace.say("606#40 08 10 00 00 00 00 00");
    let left = events(&mut trace, "705#00");
    let count = left.iter().filter(|event| matches!(event, Event::TransferLeft(_))).count();
    assert_eq!(count, 1, "{left:?}");
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    assert_eq!(bus.open_transfers().map(|open| open.0).collect::<Vec<_>>(), [node(6)]);
}

/// A COB-ID is not learned from an answer about another object or from a refused download.
#[test]
fn what_was_refused_or_mixed_up_is_not_learned() {
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 0A 01 00 40");
    trace.say("585#80 00 18 01 30 00 09 06");
    assert_eq!(trace.say("10A#01").decoded.node, None);
    trace.say("605#40 00 18 01 00 00 00 00");
    trace.say("585#43 01 18 01 0A 01 00 40");
    assert_eq!(trace.say("10A#01").decoded.node, None);
    assert_eq!(trace.say("185#01").decoded.node, Some(node(5)));
}
