//! Whole SDO transfers with their values (CiA 301, 7.2.4).

use crate::trace::Trace;
use canvass_analyzer::network::sdo::{Direction, Mode, Outcome, Transfer};
use canvass_traces::{ChannelId, Duration};

/// The frames of a dialogue with node 5, and its transfer.
fn transfer(frames: &[&str]) -> (Trace, Transfer) {
    let mut trace = Trace::new();
    let said = frames.iter().map(|frame| trace.say(frame)).last().unwrap();
    let channel = said.decoded.channel.unwrap();
    let transfer = trace.network.bus(ChannelId(0)).unwrap().transfer(channel).unwrap().clone();
    (trace, transfer)
}

#[test]
fn segments_are_counted_and_their_bytes_kept() {
    let (_, upload) = transfer(&[
        "605#40 08 10 00 00 00 00 00",
        "585#41 08 10 00 0A 00 00 00",
        "605#60 00 00 00 00 00 00 00",
        "585#00 41 42 43 44 45 46 47",
        "605#70 00 00 00 00 00 00 00",
        "585#19 48 49 4A 00 00 00 00",
    ]);
    assert_eq!(
        (upload.direction, upload.mode, upload.outcome),
        (Direction::Upload, Mode::Segmented, Outcome::Complete)
    );
    assert_eq!((upload.announced, upload.segments, upload.length()), (Some(10), 2, 10));
    assert_eq!(upload.data(), b"ABCDEFGHIJ");
    assert_eq!((upload.duration(), upload.violation), (Duration::from_millis(5), None));

    let (_, download) = transfer(&[
        "605#21 08 10 00 08 00 00 00",
        "585#60 08 10 00 00 00 00 00",
        "605#00 41 42 43 44 45 46 47",
        "585#20 00 00 00 00 00 00 00",
        "605#1D 48 00 00 00 00 00 00",
        "585#30 00 00 00 00 00 00 00",
    ]);
    assert_eq!((download.direction, download.outcome), (Direction::Download, Outcome::Complete));
    assert_eq!((download.segments, download.data()), (2, &b"ABCDEFGH"[..]));
    assert_eq!((download.duration(), download.violation), (Duration::from_millis(5), None));
}

/// The client confirms one of three segments of an upload, so the server sends the others again.
#[test]
fn a_block_goes_on_after_the_segment_that_was_confirmed() {
    let (_, upload) = transfer(&[
        "605#A4 08 10 00 03 00 00 00",
        "585#C6 08 10 00 0F 00 00 00",
        "605#A3 00 00 00 00 00 00 00",
        "585#01 41 42 43 44 45 46 47",
        "585#02 48 49 4A 4B 4C 4D 4E",
        "585#83 4F 00 00 00 00 00 00",
        "605#A2 01 03 00 00 00 00 00",
        "585#01 48 49 4A 4B 4C 4D 4E",
        "585#82 4F 00 00 00 00 00 00",
        "605#A2 02 03 00 00 00 00 00",
    ]);
    assert_eq!((upload.mode, upload.outcome, upload.announced), (Mode::Block, Outcome::Open, Some(15)));
    assert_eq!(upload.segments, 3);
    assert!(upload.data().starts_with(b"ABCDEFGHIJKLMN"), "{:?}", upload.data());
}

/// After a restart of the server, or a new request of the client, nothing of the former transfer remains, not even its
/// toggle bit.
#[test]
fn a_reset_forgets_where_a_transfer_was() {
    let mut trace = Trace::new();
    for frame in ["605#40 08 10 00 00 00 00 00", "585#41 08 10 00 0A 00 00 00", "605#60 00 00 00 00 00 00 00", "705#00"]
    {
        trace.say(frame);
    }
    let said = trace.say("585#00 41 42 43 44 45 46 47");
    assert!(said.decoded.violation.is_some(), "nothing was asked for any more: {}", said.text);
    for frame in ["605#40 08 10 00 00 00 00 00", "585#41 08 10 00 07 00 00 00", "605#60 00 00 00 00 00 00 00"] {
        assert_eq!(trace.say(frame).decoded.violation, None, "{frame}");
    }
    assert_eq!(trace.say("585#01 41 42 43 44 45 46 47").decoded.violation, None);
}

/// Node-ID 127 has the last of the predefined channels.
#[test]
fn the_last_node_has_its_own_channel() {
    let mut trace = Trace::new();
    let said = trace.say("67F#40 18 10 01 00 00 00 00");
    let channel = said.decoded.channel.unwrap();
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    assert_eq!(bus.server(channel).map(|node| node.raw()), Some(127));
    assert_eq!(channel.predefined_server().map(|node| node.raw()), Some(127));
}

/// A further SDO server (1201h) has a channel of its own, identified by its two CAN-IDs.
#[test]
fn a_further_server_is_a_channel_of_its_own() {
    let mut trace = Trace::new();
    for (sub, id) in [(1, "90 06 00 00"), (2, "A0 06 00 00")] {
        trace.say(&format!("605#23 01 12 0{sub} {id}"));
        trace.say(&format!("585#60 01 12 0{sub} 00 00 00 00"));
    }
    let asked = trace.say("690#40 18 10 01 00 00 00 00");
    let answered = trace.say("6A0#43 18 10 01 13 00 00 00");
    assert_eq!(asked.decoded.node.map(|node| node.raw()), Some(5));
    assert_eq!(asked.decoded.channel, answered.decoded.channel);
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    let channel = answered.decoded.channel.unwrap();
    assert_eq!((channel.predefined_server(), bus.server(channel).map(|node| node.raw())), (None, Some(5)));
    assert_eq!(bus.transfer(channel).unwrap().data(), [0x13, 0, 0, 0]);
}
