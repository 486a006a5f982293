//! The service of a frame and the node that it concerns, by CAN-ID (CiA 301, 7.3.3) and by learned uses.

use crate::trace::{Said, Trace};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::network::{Source, Use};
use canvass_traces::{ChannelId, Duration};

/// Service, node, and whether the node itself has sent the frame.
fn about(said: &Said) -> (&'static str, Option<u8>, bool) {
    (said.service(), said.decoded.node.map(NodeId::raw), said.decoded.is_from_node())
}

#[test]
fn every_can_id_of_the_predefined_connection_set() {
    for (frame, service, node, own) in [
        ("000#01 05", "nmt", Some(5), false),
        ("000#01 00", "nmt", None, false),
        ("000#01", "nmt", None, false),
        ("080#", "sync", None, false),
        ("085#30 81 11 00 00 00 00 00", "emcy", Some(5), true),
        ("085#30", "emcy", Some(5), true),
        ("100#00 00 00 00 00 00", "time", None, false),
        ("100#00", "time", None, false),
        ("185#00", "pdo", Some(5), true),
        ("205#00", "pdo", Some(5), false),
        ("285#00", "pdo", Some(5), true),
        ("505#00", "pdo", Some(5), false),
        ("585#60 00 20 00 00 00 00 00", "sdo", Some(5), true),
        ("605#40 00 20 00 00 00 00 00", "sdo", Some(5), false),
        ("605#", "sdo", Some(5), false),
        ("705#05", "heartbeat", Some(5), true),
        ("705#00", "boot-up", Some(5), true),
        ("705#", "heartbeat", Some(5), true),
        ("7E5#5E 00 00 00 00 00 00 00", "lss", None, false),
        ("7E4#5E 05 00 00 00 00 00 00", "lss", None, false),
        ("7E5#24 00 00 00 00 00 00 00", "lmt", None, false),
        ("001#", "srdo", None, false),
        ("071#00 05", "flying-master", Some(5), false),
        ("071#00", "flying-master", None, false),
        ("073#", "flying-master", None, false),
        ("7FF#01 02 03 00 00 00", "unknown", None, false),
        ("7FF#09 02 03 00 00 00", "unknown", None, false),
        ("101#00", "unknown", None, false),
        ("00000185#00", "unknown", None, false),
    ] {
        let said = Trace::new().say(frame);
        assert_eq!(about(&said), (service, node, own), "{frame}: {}", said.text);
        assert_eq!(said.decoded.source, Source::Predefined, "{frame}");
    }
}

/// Remote frames request a node's state or a TPDO. Any other remote frame has no meaning.
#[test]
fn remote_frames_ask() {
    for (frame, service, node) in [
        ("705#R1", "guarding", Some(5)),
        ("185#R8", "pdo", Some(5)),
        ("205#R8", "unknown", None),
        ("605#R8", "unknown", None),
        ("080#R", "unknown", None),
        ("00000705#R1", "unknown", None),
    ] {
        let said = Trace::new().say(frame);
        assert_eq!(about(&said), (service, node, false), "{frame}");
    }
    // A TPDO that has moved is requested on its new CAN-ID, which is known from the trace.
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 0A 01 00 00");
    trace.say("585#60 00 18 01 00 00 00 00");
    let said = trace.say("10A#R8");
    assert_eq!((about(&said), said.decoded.source), (("pdo", Some(5), false), Source::Trace));
    assert_eq!(trace.say("185#R8").service(), "unknown");
}

/// A message after a remote frame is no heartbeat, and neither is a message with a toggling bit (7.2.8.3.2.1).
#[test]
fn answers_of_guarding_are_told_from_heartbeats() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("705#05").service(), "heartbeat");
    trace.say("705#R1");
    assert_eq!(trace.say("705#85").service(), "guarding");
    assert_eq!(trace.say("705#05").service(), "guarding");
    assert_eq!(trace.say("705#05").service(), "heartbeat");
    // The request to another node does not count.
    trace.say("706#R1");
    assert_eq!(trace.say("705#05").service(), "heartbeat");
    // A start ends node guarding.
    trace.say("705#R1");
    trace.say("705#00");
    assert_eq!(trace.say("705#7F").service(), "heartbeat");
}

/// A learned use of a CAN-ID is dropped after a hundred frames that do not fit it.
#[test]
fn a_use_that_nothing_fits_is_given_up() {
    let learned = || {
        let mut trace = Trace::new();
        trace.say("605#23 12 10 00 90 01 00 80");
        trace.say("585#60 12 10 00 00 00 00 00");
        trace
    };
    // 190h belongs to node 16's first TPDO by default.
    let mut trace = learned();
    for n in 0..100 {
        let said = trace.say("190#01");
        assert_eq!(about(&said), ("time", None, false), "{n}");
        assert_eq!(said.decoded.source, Source::Trace, "{n}");
    }
    let said = trace.say("190#01");
    assert_eq!((about(&said), said.decoded.source), (("pdo", Some(16), true), Source::Predefined));
    // Each fitting frame makes up for one that does not fit.
    let mut trace = learned();
    for _ in 0..99 {
        trace.say("190#01");
    }
    for _ in 0..5 {
        trace.say("190#00 00 00 00 00 00");
        assert_eq!(trace.say("190#01").service(), "time");
    }
    assert_eq!(trace.say("190#01").service(), "time");
    assert_eq!(trace.say("190#01").service(), "pdo");
    // Fitting frames at the beginning do not add up: they make up for no later frame.
    let mut trace = learned();
    for _ in 0..50 {
        trace.say("190#00 00 00 00 00 00");
    }
    for _ in 0..100 {
        assert_eq!(trace.say("190#01").service(), "time");
    }
    assert_eq!(trace.say("190#01").service(), "pdo");
}

/// Uses of the predefined connection set are never dropped, nor are PDOs, which may hold any bytes.
#[test]
fn what_is_predefined_is_not_doubted() {
    let mut trace = Trace::new();
    for _ in 0..150 {
        assert_eq!(trace.say("100#01").service(), "time");
    }
    trace.say("605#23 00 18 01 0A 01 00 40");
    trace.say("585#60 00 18 01 00 00 00 00");
    for _ in 0..150 {
        assert_eq!(trace.say("10A#01").service(), "pdo");
    }
}

/// SDO messages that do not fit a further channel disprove the channel too.
#[test]
fn a_further_channel_is_given_up_as_well() {
    for unfit in ["690#E0 00 00 00 00 00 00 00", "690#60 00 00 00 00 00 00 00"] {
        let mut trace = Trace::new();
        trace.say("605#23 01 12 01 90 06 00 00");
        trace.say("585#60 01 12 01 00 00 00 00");
        trace.say("605#23 01 12 02 A0 06 00 00");
        trace.say("585#60 01 12 02 00 00 00 00");
        trace.say("690#40 18 10 01 00 00 00 00");
        trace.say("6A0#43 18 10 01 13 00 00 00");
        for n in 0..100 {
            assert_eq!(trace.say(unfit).service(), "sdo", "{n}");
        }
        assert_eq!(trace.say(unfit).service(), "unknown");
    }
}

/// A mapping count of FEh or FFh makes a PDO multiplexed: it names its object itself.
#[test]
fn a_multiplexed_pdo_names_its_object() {
    for (count, text) in [("FE", "from node 9"), ("FF", "to node 9")] {
        let mut trace = Trace::new();
        trace.say(&format!("605#2F 00 1A 00 {count} 00 00 00"));
        trace.say("585#60 00 1A 00 00 00 00 00");
        let address = if count == "FE" { "09" } else { "89" };
        let said = trace.say(&format!("185#{address} 00 20 01 11 22 33 44"));
        assert_eq!(about(&said), ("pdo", Some(5), true), "{}", said.text);
        assert!(said.text.contains(text), "{}", said.text);
        assert_eq!(said.decoded.object.map(|object| object.to_string()).as_deref(), Some("2000h:01"));
        let short = trace.say(&format!("185#{address}"));
        assert_eq!((short.service(), short.decoded.object), ("pdo", None));
        assert!(matches!(short.decoded.message, canvass_analyzer::Message::Malformed(..)));
        // With an ordinary mapping, the PDO is an ordinary one again.
        trace.say("605#2F 00 1A 00 00 00 00 00");
        trace.say("585#60 00 1A 00 00 00 00 00");
        assert_eq!(trace.say(&format!("185#{address} 00 20 01 11 22 33 44")).decoded.object, None);
    }
}

/// An LMT device on the bus decides that messages which both protocols have are LMT messages, until an LSS message
/// comes.
#[test]
fn the_last_message_of_one_protocol_alone_decides() {
    let ambiguous = "7E5#13 00 05 00 00 00 00 00";
    let mut trace = Trace::new();
    assert_eq!(trace.say(ambiguous).service(), "lss");
    trace.say("7E5#24 00 00 00 00 00 00 00");
    assert_eq!(trace.say(ambiguous).service(), "lmt");
    assert_eq!(trace.say("7E4#13 00 00 00 00 00 00 00").service(), "lmt");
    trace.say("7E4#5E 05 00 00 00 00 00 00");
    assert_eq!(trace.say(ambiguous).service(), "lss");
    assert_eq!(trace.say("7E4#13 00 00 00 00 00 00 00").service(), "lss");
    // Devices without a statement about LSS or LMT do not decide the protocol.
    let mut trace = Trace::new();
    trace.network.describe(NodeId::new(5).unwrap(), KnownDevice::default());
    assert_eq!(trace.say(ambiguous).service(), "lss");
}

/// The inverted twin of an SRDO comes within the validation time, which is a byte of milliseconds (CiA 304).
#[test]
fn a_pair_of_frames_is_an_srdo() {
    let mut trace = Trace::new();
    assert_eq!(about(&trace.say("109#55 01")), ("unknown", None, false));
    // The pair of node 5 is 109h and 10Ah.
    let said = trace.say("10A#AA FE");
    assert_eq!(about(&said), ("srdo", Some(5), false));
    assert_eq!(said.text, "SRDO inverted data");
    assert_eq!(trace.say("109#55 01").service(), "srdo");
    assert_eq!(trace.say("10A#AA FF").text, "SRDO inverted data, not the inverse of the data");
    assert_eq!(trace.say("10A#AA FE").text, "SRDO inverted data, without the data before it");
    trace.say("109#55 01");
    trace.now += Duration::from_millis(254);
    assert_eq!(trace.say("10A#AA FE").text, "SRDO inverted data");
    trace.say("109#55 01");
    trace.now += Duration::from_millis(255);
    assert_eq!(trace.say("10A#AA FE").text, "SRDO inverted data, without the data before it");
    // Each of the other pairs is known independently.
    assert_eq!(trace.say("10B#55 01").service(), "unknown");
    assert_eq!(trace.say("17F#00").service(), "unknown");
    assert_eq!(about(&trace.say("180#FF")), ("srdo", Some(64), false));
    trace.say("101#00");
    assert_eq!(about(&trace.say("102#FF")), ("srdo", Some(1), false));
    // Two frames without bytes prove nothing.
    trace.say("103#");
    assert_eq!(trace.say("104#").service(), "unknown");
}

/// The CAN-IDs of an SRDO have a use while the node sends or receives the SRDO.
#[test]
fn an_srdo_that_is_sent_or_received_has_its_can_ids() {
    let node = NodeId::new(5).unwrap();
    let mut trace = Trace::new();
    let mut show = |object: &str, value: &str| {
        trace.say(&format!("605#23 {object} {value}"));
        trace.say(&format!("585#60 {object} 00 00 00 00"));
        let events = trace.network.bus(ChannelId(0)).unwrap().events().to_vec();
        let moves = events.into_iter().filter_map(|event| match event {
            canvass_analyzer::network::Event::CobIdMoved(moved) => Some((moved.used, moved.from, moved.to)),
            _ => None,
        });
        moves.collect::<Vec<_>>()
    };
    use canvass_analyzer::wire::srdo::Half;
    let data = Use::Srdo(node, 1, Half::Normal);
    let inverted = Use::Srdo(node, 1, Half::Inverted);
    assert_eq!(show("01 13 05", "21 01 00 00"), [(data, None, Some(0x121))]);
    assert_eq!(show("01 13 06", "22 01 00 00"), [(inverted, None, Some(0x122))]);
    assert_eq!(show("01 13 01", "01 00 00 00"), [], "it sends");
    assert_eq!(show("01 13 01", "00 00 00 00"), [(data, Some(0x121), None), (inverted, Some(0x122), None)]);
    assert_eq!(show("01 13 01", "02 00 00 00"), [(data, None, Some(0x121)), (inverted, None, Some(0x122))]);
    // The last of 64 SRDOs, and objects outside the SRDO parameters.
    let last = Use::Srdo(node, 64, Half::Normal);
    assert_eq!(show("40 13 05", "31 01 00 00"), [(last, None, Some(0x131))]);
    assert_eq!(show("41 13 05", "33 01 00 00"), []);
    assert_eq!(show("00 13 05", "33 01 00 00"), []);
    assert_eq!(show("02 13 04", "33 01 00 00"), []);
    assert_eq!(show("02 13 05", "00 00 00 00"), [], "0 is no CAN-ID");
}
