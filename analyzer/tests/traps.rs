//! Conventions on the wire that break naive decoders, one test each.

#[cfg(test)]
mod trace;

use canvass_analyzer::network::Source;
use canvass_analyzer::network::sdo::Violation;
use canvass_analyzer::wire::error_control::State;
use canvass_traces::{CanId, ChannelId, Duration, ErrorClass, Flags, Frame, Record, Timestamp};
use trace::{Said, Trace};

/// Service and text of a single frame on a new network.
fn alone(frame: &str) -> (&'static str, String) {
    let said = Trace::new().say(frame);
    (said.service(), said.text)
}

fn node(said: &Said) -> Option<u8> {
    said.decoded.node.map(|node| node.raw())
}

/// 21h is "initiate download" as a command, and segment 33 in a block.
#[test]
fn a_block_segment_33_is_no_command() {
    let mut trace = Trace::new();
    trace.say("605#C2 50 1F 01 2C 01 00 00");
    trace.say("585#A0 50 1F 01 7F 00 00 00");
    for sequence in 1..33 {
        trace.say(&format!("605#{sequence:02X} 00 00 00 00 00 00 00"));
    }
    let said = trace.say("605#21 00 10 00 05 00 00 00");
    assert_eq!(said.text.split(" of").next(), Some("block segment 33"));
    assert_eq!(said.decoded.violation, None);
    // On another node at the same time, 21h is the command.
    assert_eq!(trace.say("606#21 00 10 00 05 00 00 00").text, "write 1000h:00 Device type, 5 bytes in segments");
    assert!(trace.say("605#22 00 00 00 00 00 00 00").text.starts_with("block segment 34"));
}

/// A segment of the server's block upload that looks like an answer is decoded as a segment.
#[test]
fn a_block_segment_of_an_upload_is_no_answer() {
    let mut trace = Trace::new();
    trace.say("605#A0 50 1F 01 7F 00 00 00");
    trace.say("585#C2 50 1F 01 F4 01 00 00");
    trace.say("605#A3 00 00 00 00 00 00 00");
    for sequence in 1..0x43 {
        trace.say(&format!("585#{sequence:02X} 00 00 00 00 00 00 00"));
    }
    let said = trace.say("585#43 00 10 00 96 01 02 00");
    assert!(said.text.starts_with("block segment 67 of 1F50h:01"), "{}", said.text);
    assert_eq!(said.decoded.violation, None);
}

#[test]
fn transfers_of_different_nodes_interleave() {
    let mut trace = Trace::new();
    trace.say("605#40 08 10 00 00 00 00 00");
    trace.say("606#40 08 10 00 00 00 00 00");
    trace.say("586#41 08 10 00 03 00 00 00");
    trace.say("585#41 08 10 00 03 00 00 00");
    trace.say("605#60 00 00 00 00 00 00 00");
    trace.say("606#60 00 00 00 00 00 00 00");
    assert!(trace.say("585#09 61 62 63 00 00 00 00").text.contains("\"abc\""));
    assert!(trace.say("586#09 78 79 7A 00 00 00 00").text.contains("\"xyz\""));
}

#[test]
fn a_pdo_on_10a_is_no_time() {
    assert_eq!(alone("10A#00 00 00 00 00 00"), ("unknown", "no known use of this CAN-ID".to_owned()));
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 0A 01 00 00");
    trace.say("585#60 00 18 01 00 00 00 00");
    let said = trace.say("10A#00 00 00 00 00 00");
    assert_eq!((said.service(), node(&said), said.decoded.source), ("pdo", Some(5), Source::Trace));
    assert_eq!(alone("100#00 00 00 00 00 00").0, "time");
}

/// A PDO on 10Bh and its inverse on 10Ch are an SRDO, unless 10Bh is known to be a PDO.
#[test]
fn an_srdo_needs_its_inverted_twin() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("10B#12 34").service(), "unknown");
    assert_eq!(trace.say("10C#12 34").service(), "unknown");
    assert_eq!(trace.say("10B#12 34").service(), "unknown");
    let said = trace.say("10C#ED CB");
    assert_eq!((said.service(), node(&said), said.text.as_str()), ("srdo", Some(6), "SRDO inverted data"));
    let said = trace.say("10B#12 35");
    assert_eq!((said.service(), said.text.as_str()), ("srdo", "SRDO data"));
    assert_eq!(trace.say("10C#ED CB").text, "SRDO inverted data, not the inverse of the data");
    assert_eq!(trace.say("10C#ED CA").text, "SRDO inverted data, without the data before it");
    // 10Ah and 10Bh are neighbours, but not a pair.
    trace.say("10E#12 34");
    assert_eq!(trace.say("10F#ED CB").service(), "unknown");

    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 0B 01 00 00");
    trace.say("585#60 00 18 01 00 00 00 00");
    assert_eq!(trace.say("10B#12 34").service(), "pdo");
    assert_eq!(trace.say("10C#ED CB").service(), "unknown");
}

#[test]
fn an_inverted_twin_too_late_is_none() {
    let mut trace = Trace::new();
    trace.say("101#12 34");
    trace.now += Duration(1_000_000_000);
    assert_eq!(trace.say("102#ED CB").service(), "unknown");
}

#[test]
fn ids_below_080_are_not_nmt() {
    assert_eq!(
        alone("071#01 05"),
        ("flying-master", "flying master: active master is node 5, priority 1 (medium)".into())
    );
    assert_eq!(alone("073#"), ("flying-master", "flying master: active master request".into()));
    assert_eq!(
        alone("071#01").1,
        "malformed flying-master: expected the master's node-ID at byte 1, found 1 bytes in all"
    );
    assert_eq!(alone("001#"), ("srdo", "global fail-safe command".into()));
    assert_eq!(alone("002#01 05").0, "unknown");
    assert_eq!(alone("07F#01 05").0, "unknown");
}

/// The case markers of CiA's test tool, and anything else on their CAN-ID.
#[test]
fn case_markers_of_a_certification_run() {
    assert_eq!(alone("7FF#01 03 07 00 00 00"), ("unknown", "CiA test tool: case 7 of group 3 begins".into()));
    assert_eq!(alone("7FF#02 03 07 00 05 00"), ("unknown", "CiA test tool: case 7 of group 3 ends: skipped".into()));
    assert_eq!(alone("7FF#02 03").1, "no known use of this CAN-ID");
}

/// 1200h:1 and 1200h:2 written: the server listens on 241h and answers on 1C1h.
#[test]
fn an_sdo_channel_moves_when_it_is_written() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("241#40 00 10 00 00 00 00 00").service(), "pdo");
    trace.say("605#23 00 12 01 41 02 00 00");
    trace.say("585#60 00 12 01 00 00 00 00");
    trace.say("241#23 00 12 02 C1 01 00 00");
    trace.say("585#60 00 12 02 00 00 00 00");
    let said = trace.say("241#40 18 10 01 00 00 00 00");
    assert_eq!((said.service(), node(&said)), ("sdo", Some(5)));
    let said = trace.say("1C1#43 18 10 01 13 00 00 00");
    assert_eq!(said.text, "read answered: 1018h:01 Identity object, Vendor-ID = 00000013h");
    assert_eq!(said.decoded.violation, None);
}

/// 1201h, the parameter of a second server, is only read.
#[test]
fn an_sdo_channel_is_known_when_it_is_read() {
    let mut trace = Trace::new();
    for (sub, answer) in [("01", "41 02"), ("02", "C1 01")] {
        trace.say(&format!("605#40 01 12 {sub} 00 00 00 00"));
        trace.say(&format!("585#43 01 12 {sub} {answer} 00 00"));
    }
    assert_eq!(node(&trace.say("241#40 18 10 01 00 00 00 00")), Some(5));
    assert_eq!(trace.say("1C1#43 18 10 01 13 00 00 00").service(), "sdo");
    // The first server stays on its default CAN-IDs.
    assert_eq!(trace.say("605#40 18 10 01 00 00 00 00").service(), "sdo");
}

/// A boot-up moves the channel back to its default CAN-IDs.
#[test]
fn a_boot_up_undoes_what_was_not_stored() {
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 0A 01 00 00");
    trace.say("585#60 00 18 01 00 00 00 00");
    assert_eq!(trace.say("185#00").service(), "unknown");
    trace.say("705#00");
    assert_eq!((trace.say("185#00").service(), trace.say("10A#00").service()), ("pdo", "unknown"));
}

/// 85h is no heartbeat: without remote frames the toggle bit still shows guarding; with remote frames 05h is guarding
/// too.
#[test]
fn guarding_is_told_by_its_polls() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("705#05").service(), "heartbeat");
    assert_eq!(trace.say("705#R1").text, "guarding request");
    assert_eq!(trace.say("705#85").text, "guarding: operational, toggle 1");
    trace.say("705#R1");
    let said = trace.say("705#05");
    assert_eq!((said.service(), said.text.as_str()), ("guarding", "guarding: operational, toggle 0"));
    // After its boot-up the node may send heartbeats.
    assert_eq!(trace.say("705#00").service(), "boot-up");
    assert_eq!(trace.say("705#05").service(), "heartbeat");
}

#[test]
fn an_empty_emcy_is_the_boot_up_of_old_devices() {
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 0A 01 00 00");
    trace.say("585#60 00 18 01 00 00 00 00");
    let said = trace.say("085#");
    assert_eq!((said.service(), node(&said)), ("boot-up", Some(5)));
    assert!(said.text.contains("boot-up"), "{}", said.text);
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    let state = said.decoded.node.and_then(|node| bus.node(node)).and_then(|node| node.state);
    assert_eq!(state.map(|state| state.0), Some(State::PRE_OPERATIONAL));
    assert_eq!(trace.say("185#00").service(), "pdo");
}

#[test]
fn an_emcy_may_be_short() {
    let (service, text) = alone("085#30 81 11 00 00");
    assert_eq!(service, "emcy");
    assert!(text.contains("8130h") && text.ends_with("data 00 00"), "{text}");
    assert!(alone("085#30 81").1.ends_with("8130h life guard error or heartbeat error"));
    assert_eq!(alone("085#30"), ("emcy", "EMCY cut: 30".to_owned()));
}

#[test]
fn an_nmt_command_may_be_long() {
    assert_eq!(alone("000#01 05 00 00 00 00 00 00"), ("nmt", "start remote node, node 5".to_owned()));
    assert_eq!(alone("000#01").1, "malformed nmt: expected a node-ID at byte 1, found 1 bytes in all");
}

#[test]
fn an_sdo_may_be_short() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("605#40 00 10 00").text, "read 1000h:00 Device type");
    assert_eq!(
        trace.say("585#4F 00 10 00 07").text,
        "read answered: 1000h:00 Device type = 7 [UNSIGNED32 has 4 bytes, found 1]"
    );
    let said = trace.say("605#40 00");
    assert_eq!(said.text, "malformed sdo: expected index and sub-index at byte 1, found 2 bytes in all");
    assert_eq!(said.service(), "sdo");
    assert_eq!(trace.say("605#").service(), "sdo");
}

#[test]
fn the_upper_bits_of_time_are_reserved() {
    assert_eq!(alone("100#00 00 00 F0 3C 00"), ("time", "TIME 1984-03-01 00:00:00.000 (reserved bits Fh)".to_owned()));
    assert_eq!(
        alone("100#00 00 00").1,
        "malformed time: expected milliseconds after midnight, 4 bytes at byte 0, found 3 bytes in all"
    );
}

#[test]
fn a_sync_has_no_byte_or_one() {
    assert_eq!(alone("080#"), ("sync", "SYNC".to_owned()));
    assert_eq!(alone("080#07"), ("sync", "SYNC, counter 7".to_owned()));
    assert_eq!(alone("080#F1"), ("sync", "SYNC, counter 241 (outside 1..240)".to_owned()));
    assert_eq!(alone("080#07 00").0, "sync");
}

#[test]
fn other_kinds_of_frames_are_not_misread() {
    assert_eq!(alone("00000705#00"), ("unknown", "29-bit identifier: not classical CANopen".to_owned()));
    assert_eq!(alone("705##100").0, "unknown");
    assert_eq!(alone("705##100").1, "CAN FD: not classical CANopen");
    assert_eq!(alone("185#R4"), ("pdo", "TPDO 1 requested".to_owned()));
    assert_eq!(alone("605#R8"), ("unknown", "remote frame".to_owned()));
    assert_eq!(alone("00000705#R1"), ("unknown", "remote frame".to_owned()));
    let long = Record::fd(Timestamp::ZERO, ChannelId(0), CanId::standard_masked(0x605), Flags::FDF, &[0x40; 64]);
    assert_eq!(Trace::new().record(long.unwrap()).service(), "unknown");
}

/// A foreign frame in the middle of a transfer does not disturb it.
#[test]
fn foreign_frames_do_not_disturb_a_transfer() {
    let mut trace = Trace::new();
    trace.say("605#40 00 10 00 00 00 00 00");
    for foreign in ["00000605#40 01 10 00 00 00 00 00", "605##140001100", "605#R8", "585#R8"] {
        trace.say(foreign);
    }
    let said = trace.say("585#43 00 10 00 96 01 02 00");
    assert_eq!((said.decoded.violation, said.text.starts_with("read answered: 1000h:00")), (None, true));
}

#[test]
fn error_frames_are_told_in_words() {
    let frame = Frame::error(ErrorClass(0x208), &[0, 0, 0x04, 0x19, 0, 0, 8, 0]).unwrap();
    let said = Trace::new().record(Record::new(Timestamp::ZERO, ChannelId(0), frame));
    assert_eq!(said.service(), "error-frame");
    assert_eq!(
        said.text,
        "error frame: protocol violation (bit stuffing error) at acknowledge slot, transmit errors 8, receive errors 0"
    );
}

/// The same bytes on 7E5h: LSS after an LSS message, LMT after an LMT message.
#[test]
fn lmt_and_lss_are_told_by_their_dialogue() {
    let mut trace = Trace::new();
    assert_eq!(trace.say("7E5#13 00 05 00 00 00 00 00").text, "LSS configure bit timing: reserved index 5");
    assert_eq!(trace.say("7E4#24 54 52 2D 45 4C 45 43").text, "LMT manufacturer name \"TR-ELEC\"");
    let said = trace.say("7E5#13 00 05 00 00 00 00 00");
    assert_eq!((said.service(), said.text.as_str()), ("lmt", "LMT configure bit timing: 50 kbit/s"));
    assert_eq!(trace.say("7E5#5E 00 00 00 00 00 00 00").text, "LSS inquire node-ID");
    assert_eq!(trace.say("7E5#13 00 05 00 00 00 00 00").service(), "lss");
}

/// A PDO whose mapping count is FEh or FFh names its object itself.
#[test]
fn a_multiplexed_pdo_names_its_object() {
    let mut trace = Trace::new();
    for frame in ["605#40 00 10 00 00 00 00 00", "585#43 00 10 00 96 01 02 00"] {
        trace.say(frame);
    }
    trace.say("605#2F 00 1A 00 FE 00 00 00");
    trace.say("585#60 00 1A 00 00 00 00 00");
    let said = trace.say("185#05 04 60 00 BA 4C 00 00");
    assert_eq!(said.text, "TPDO 1, multiplexed, from node 5: 6004h:00 Position value = 19642 steps");
    assert_eq!(said.service(), "pdo");
    assert!(trace.say("185#05 04").text.starts_with("malformed pdo"));

    trace.say("605#2F 00 1A 00 FF 00 00 00");
    trace.say("585#60 00 1A 00 00 00 00 00");
    assert!(trace.say("185#80 04 60 00 BA 4C 00 00").text.starts_with("TPDO 1, multiplexed, to all nodes: 6004h:00"));
    // The mapping is an ordinary one again.
    trace.say("605#2F 00 1A 00 00 00 00 00");
    trace.say("585#60 00 1A 00 00 00 00 00");
    assert_eq!(trace.say("185#05 04").text, "TPDO 1, 2 bytes, mapping not known");
}

/// An abort code of CAL, from the time before CiA 301 V4, which no table of CiA 301 has.
#[test]
fn an_abort_code_of_cal_has_a_meaning() {
    let mut trace = Trace::new();
    trace.say("605#23 10 10 01 73 61 76 65");
    let said = trace.say("585#80 10 10 01 06 00 00 06");
    assert!(said.text.ends_with("0600 0006h access error, hardware fault (CAL)"), "{}", said.text);
}

/// The capture lacks the beginning of a transfer.
#[test]
fn a_capture_may_begin_in_a_transfer() {
    let mut trace = Trace::new();
    let said = trace.say("585#43 00 10 00 96 01 02 00");
    assert_eq!(said.decoded.violation, Some(Violation::Unexpected));
    assert!(said.text.starts_with("read answered: 1000h:00"));
}

/// The five steps of Sendix manual 5.7.4 to change a mapping: switch off, set the count to 0, write the entries, set
/// the count, switch on. Values before and after the change are read by the mapping of their time; in between there is
/// no mapping.
#[test]
fn a_mapping_changes_in_the_middle_of_a_trace() {
    let mut trace = Trace::new();
    for frame in [
        "63F#40 00 10 00 00 00 00 00",
        "5BF#43 00 10 00 96 01 02 00",
        "63F#40 00 1A 00 00 00 00 00",
        "5BF#4F 00 1A 00 01 00 00 00",
        "63F#40 00 1A 01 00 00 00 00",
        "5BF#43 00 1A 01 20 00 04 60",
    ] {
        trace.say(frame);
    }
    assert_eq!(trace.say("1BF#BA 4C 00 00").text, "TPDO 1: 6004h:00 Position value = 19642 steps");
    let write = |trace: &mut Trace, request: &str, object: &str| {
        trace.say(&format!("63F#{request}"));
        trace.say(&format!("5BF#60 {object} 00 00 00 00"));
    };
    write(&mut trace, "23 00 18 01 BF 01 00 80", "00 18 01");
    assert_eq!(trace.say("1BF#BA 4C 00 00").service(), "unknown", "the PDO is switched off");
    write(&mut trace, "2F 00 1A 00 00 00 00 00", "00 1A 00");
    write(&mut trace, "23 00 1A 01 10 01 30 60", "00 1A 01");
    write(&mut trace, "23 00 1A 02 20 00 04 60", "00 1A 02");
    write(&mut trace, "2F 00 1A 00 02 00 00 00", "00 1A 00");
    write(&mut trace, "23 00 18 01 BF 01 00 00", "00 18 01");
    let said = trace.say("1BF#AF 04 BB 4C 00 00");
    assert_eq!(said.service(), "pdo");
    let speed = "6030h:01 Speed value, Speed value channel 1 = ";
    assert!(said.text.starts_with(&format!("TPDO 1: {speed}")), "{}", said.text);
    assert!(said.text.ends_with("6004h:00 Position value = 19643 steps"), "{}", said.text);
}
