//! Events that frames cause on their bus.

use crate::trace::Trace;
use crate::{events, node, select_node_63};
use canvass_analyzer::PdoNumber;
use canvass_analyzer::network::sdo::Outcome;
use canvass_analyzer::network::{Event, Exchange, Move, Source, Use};
use canvass_traces::{ChannelId, Duration};

#[test]
fn a_frame_begins_a_new_list() {
    let mut trace = Trace::new();
    assert_eq!(events(&mut trace, "701#05").len(), 1);
    assert_eq!(events(&mut trace, "701#05"), []);
    assert_eq!(events(&mut trace, "181#00"), []);
}

/// The trace has shown the four numbers of a node's LSS address. The slave that is selected by them is this node.
#[test]
fn a_new_node_id_is_followed_by_the_lss_address() {
    let mut trace = Trace::new();
    select_node_63(&mut trace);
    trace.say("7E4#44 00 00 00 00 00 00 00");
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    // Another node starts meanwhile.
    assert_eq!(events(&mut trace, "701#00").len(), 1);
    let changed = Event::NodeIdChanged { from: Some(node(63)), to: node(42), object: None };
    assert!(events(&mut trace, "72A#00").contains(&changed));
    assert!(!events(&mut trace, "72A#00").contains(&changed), "it has it since then");
}

#[test]
fn a_refused_node_id_changes_nothing() {
    let mut trace = Trace::new();
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    let refused = events(&mut trace, "7E4#11 01 00 00 00 00 00 00");
    assert_eq!(refused, [Event::LayerSetting(Exchange::Response(Duration::from_millis(1)))]);
    assert_eq!(events(&mut trace, "72A#00").len(), 1);
}

#[test]
fn an_lmt_address_is_followed_too() {
    let mut trace = Trace::new();
    trace.say("7E5#04 01 00 00 00 00 00 00");
    trace.say("7E5#24 00 00 00 00 00 00 00");
    trace.say("7E5#11 07 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    assert!(events(&mut trace, "707#00").contains(&Event::NodeIdChanged { from: None, to: node(7), object: None }));
}

#[test]
fn what_moves_is_told_once() {
    let mut trace = Trace::new();
    trace.say("605#23 00 18 01 10 01 00 40");
    let moved = Move {
        used: Use::Pdo(node(5), PdoNumber::Transmit(1)),
        from: Some(0x185),
        to: Some(0x110),
        source: Source::Trace,
    };
    assert_eq!(events(&mut trace, "585#60 00 18 01 00 00 00 00"), [Event::TransferEnded, Event::CobIdMoved(moved)]);
    trace.say("605#40 00 18 01 00 00 00 00");
    assert_eq!(events(&mut trace, "585#43 00 18 01 10 01 00 40"), [Event::TransferEnded]);
    trace.say("605#23 00 18 01 10 01 00 C0");
    let gone = Move { from: Some(0x110), to: None, ..moved };
    assert_eq!(events(&mut trace, "585#60 00 18 01 00 00 00 00"), [Event::TransferEnded, Event::CobIdMoved(gone)]);
}

#[test]
fn a_transfer_that_is_left_can_be_looked_at() {
    let mut trace = Trace::new();
    trace.say("605#40 08 10 00 00 00 00 00");
    let left = events(&mut trace, "605#40 00 10 00 00 00 00 00");
    let [Event::TransferLeft(channel)] = left[..] else { panic!("{left:?}") };
    let bus = trace.network.bus(ChannelId(0)).unwrap();
    let transfer = bus.left_transfer(channel).unwrap();
    assert_eq!((transfer.multiplexer.index.0, transfer.outcome), (0x1008, Outcome::Superseded));
    assert_eq!(bus.open_transfers().count(), 1);
    assert_eq!(bus.server(channel), Some(node(5)));
}
