//! Parameters that a node keeps over its next start: 1010h stores, 1011h restores the defaults (CiA 301, 7.5.2.13 and
//! 7.5.2.14).

use crate::node;
use crate::trace::Trace;
use canvass_analyzer::PdoNumber;
use canvass_analyzer::network::{Event, Move, Source, Use};
use canvass_traces::ChannelId;

/// Node 5 accepts a download of four bytes.
fn written(trace: &mut Trace, object: &str, value: &str) {
    trace.say(&format!("605#23 {object} {value}"));
    trace.say(&format!("585#60 {object} 00 00 00 00"));
}

/// Node 5 answers an upload with four bytes.
fn shown(trace: &mut Trace, object: &str, value: &str) {
    trace.say(&format!("605#40 {object} 00 00 00 00"));
    trace.say(&format!("585#43 {object} {value}"));
}

/// Node 5 starts. Returns the events beside the change of its state.
fn started(trace: &mut Trace) -> Vec<Event> {
    trace.say("705#00");
    let mut all = trace.network.bus(ChannelId(0)).unwrap().events().to_vec();
    all.retain(|event| !matches!(event, Event::StateChanged(..)));
    all
}

const TPDO: &str = "00 18 01";
const MOVED: &str = "0A 01 00 40";

/// Whether node 5's first TPDO is still at 10Ah.
fn is_moved(trace: &mut Trace) -> bool {
    let there = trace.say("10A#01").decoded.node == Some(node(5));
    let home = trace.say("185#01").decoded.node == Some(node(5));
    assert_ne!(there, home);
    there
}

fn back_home() -> Event {
    let used = Use::Pdo(node(5), PdoNumber::Transmit(1));
    Event::CobIdMoved(Move { used, from: Some(0x10A), to: Some(0x185), source: Source::Predefined })
}

const SAVE: &str = "73 61 76 65";
const LOAD: &str = "6C 6F 61 64";

/// Sub-index 1 stores all parameters, 2 communication (1000h to 1FFFh), 3 the application (6000h to 9FFFh). Further
/// sub-indexes belong to the manufacturer.
#[test]
fn each_sub_index_stores_its_own() {
    for (sub, kept) in [(1, true), (2, true), (3, false), (4, false)] {
        let mut trace = Trace::new();
        written(&mut trace, TPDO, MOVED);
        written(&mut trace, &format!("10 10 0{sub}"), SAVE);
        assert_eq!(started(&mut trace), if kept { vec![] } else { vec![back_home()] }, "{sub}");
        assert_eq!(is_moved(&mut trace), kept, "{sub}");
    }
}

/// The unit of a position shows whether 6001h was kept.
#[test]
fn parameters_of_the_application_are_stored_too() {
    for (sub, kept) in [(1, true), (2, false), (3, true), (4, false)] {
        let mut trace = Trace::new();
        shown(&mut trace, "00 10 00", "96 01 02 00");
        written(&mut trace, "01 60 00", "10 0E 00 00");
        written(&mut trace, &format!("10 10 0{sub}"), SAVE);
        started(&mut trace);
        trace.say("605#40 04 60 00 00 00 00 00");
        let position = trace.say("585#43 04 60 00 BA 4C 00 00").text;
        assert_eq!(position.ends_with("(1964.2°)"), kept, "{sub}: {position}");
    }
}

/// Only the signature stores, and only if the device accepts it.
#[test]
fn without_its_signature_nothing_is_stored() {
    for (request, answer) in [
        ("605#23 10 10 01 65 76 61 73", "585#60 10 10 01 00 00 00 00"),
        ("605#23 10 10 01 73 61 76 65", "585#80 10 10 01 20 00 00 08"),
        ("605#23 11 10 01 73 61 76 65", "585#60 11 10 01 00 00 00 00"),
        ("605#40 10 10 01 00 00 00 00", "585#43 10 10 01 73 61 76 65"),
    ] {
        let mut trace = Trace::new();
        written(&mut trace, TPDO, MOVED);
        trace.say(request);
        trace.say(answer);
        assert_eq!(started(&mut trace), [back_home()], "{request}");
        assert!(!is_moved(&mut trace));
    }
}

/// A value that was read before any write is the value with which the device starts.
#[test]
fn what_was_read_was_there_before() {
    let mut trace = Trace::new();
    shown(&mut trace, TPDO, MOVED);
    assert_eq!(started(&mut trace), []);
    assert!(is_moved(&mut trace));
    // The value was written and then read back, so the device did not start with it.
    let mut trace = Trace::new();
    written(&mut trace, TPDO, MOVED);
    shown(&mut trace, TPDO, MOVED);
    assert_eq!(started(&mut trace), [back_home()]);
    // The value was read, then written; the start restores the value that was read.
    let mut trace = Trace::new();
    shown(&mut trace, TPDO, MOVED);
    written(&mut trace, TPDO, "0C 01 00 40");
    let used = Use::Pdo(node(5), PdoNumber::Transmit(1));
    let back = Move { used, from: Some(0x10C), to: Some(0x10A), source: Source::Trace };
    assert_eq!(started(&mut trace), [Event::CobIdMoved(back)]);
    assert!(is_moved(&mut trace));
}

/// The defaults take effect with the start after 1011h, not before. Defaults of the application alone move no COB-ID.
#[test]
fn defaults_come_back_with_the_next_start() {
    for (sub, value, kept) in [(1, LOAD, false), (2, LOAD, false), (3, LOAD, true), (1, SAVE, true)] {
        let mut trace = Trace::new();
        written(&mut trace, TPDO, MOVED);
        written(&mut trace, "10 10 01", SAVE);
        written(&mut trace, &format!("11 10 0{sub}"), value);
        assert!(is_moved(&mut trace), "{sub}");
        assert_eq!(started(&mut trace), if kept { vec![] } else { vec![back_home()] }, "{sub} {value}");
    }
    // A read of "load" from 1011h only says that the device can restore defaults.
    let mut trace = Trace::new();
    shown(&mut trace, TPDO, MOVED);
    shown(&mut trace, "11 10 01", LOAD);
    assert_eq!(started(&mut trace), []);
}

/// Device type and resolution belong to the device: restoring defaults does not change them.
#[test]
fn what_the_device_is_survives_its_defaults() {
    let mut trace = Trace::new();
    shown(&mut trace, "00 10 00", "96 01 02 00");
    shown(&mut trace, "01 65 00", "00 20 00 00");
    shown(&mut trace, "00 60 00", "00 00 00 00");
    shown(&mut trace, "01 60 00", "10 0E 00 00");
    written(&mut trace, "11 10 01", LOAD);
    let position = |trace: &mut Trace| {
        trace.say("605#40 04 60 00 00 00 00 00");
        trace.say("585#43 04 60 00 BA 4C 00 00").text
    };
    assert!(position(&mut trace).ends_with("= 19642 steps (863.173828°)"));
    started(&mut trace);
    // 6000h and 6001h are not known any more.
    assert!(position(&mut trace).ends_with("= 19642 steps"));
    shown(&mut trace, "00 60 00", "00 00 00 00");
    assert!(position(&mut trace).ends_with("= 19642 steps (863.173828°)"));
}

/// A start of node 5 changes no COB-ID of another node.
#[test]
fn each_node_forgets_its_own() {
    let mut trace = Trace::new();
    written(&mut trace, TPDO, MOVED);
    trace.say("706#00");
    assert!(is_moved(&mut trace));
    // SYNC belongs to no node.
    written(&mut trace, "05 10 00", "90 00 00 00");
    started(&mut trace);
    trace.say("701#00");
    assert_eq!(trace.say("090#").service(), "sync");
}

/// Further SDO servers lose their CAN-IDs too, as 1201h has none by default.
#[test]
fn further_servers_are_forgotten_as_long_as_they_are_not_stored() {
    for store in [false, true] {
        let mut trace = Trace::new();
        written(&mut trace, "01 12 01", "90 06 00 00");
        written(&mut trace, "01 12 02", "A0 06 00 00");
        assert_eq!(trace.say("690#40 18 10 01 00 00 00 00").decoded.node, Some(node(5)));
        if store {
            written(&mut trace, "10 10 01", SAVE);
        }
        let events = started(&mut trace);
        let left = events.iter().filter(|event| matches!(event, Event::TransferLeft(_))).count();
        assert_eq!(left, 1, "{events:?}");
        let gone = |event: &Event| {
            matches!(event, Event::CobIdMoved(Move { used: Use::SdoRequest(_) | Use::SdoResponse(_), to: None, .. }))
        };
        assert_eq!(events.iter().filter(|event| gone(event)).count(), if store { 0 } else { 2 }, "{events:?}");
        assert_eq!(trace.say("690#40 18 10 01 00 00 00 00").service(), if store { "sdo" } else { "unknown" });
    }
}
