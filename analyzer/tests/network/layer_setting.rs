//! Dialogues of LMT, and the addresses of LSS.

use crate::trace::Trace;
use crate::{events, node, select_node_63};
use canvass_analyzer::network::{Event, Exchange};
use canvass_traces::Duration;

/// A missing answer to a request of LMT is reported with the next request (CiA 205-2).
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
        // LMT's own command to inquire the manufacturer name.
        trace.say("7E5#24 00 00 00 00 00 00 00");
        trace.say("7E4#24 41 42 43 20 20 20 20");
        assert_eq!(events(&mut trace, request), [asked(false)], "{request}");
        assert_eq!(events(&mut trace, request), [asked(answered)], "{request}");
        let answer = Event::LayerSetting(Exchange::Response(Duration::from_millis(1)));
        assert_eq!(events(&mut trace, "7E4#17 00 00 00 00 00 00 00"), [answer], "{request}");
    }
}

/// Table 0 of LMT: code 3 is 250 kbit/s, code 7 is 20 kbit/s. The bit rate takes effect only if it was confirmed.
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
    // After a switch to another slave, a confirmation does not count for the request to the slave before.
    for switch in ["7E5#04 00 00 00 00 00 00 00", "7E5#01 41 42 43 20 20 20 20"] {
        let mut trace = Trace::new();
        trace.say("7E5#24 00 00 00 00 00 00 00");
        trace.say("7E5#11 07 00 00 00 00 00 00");
        trace.say(switch);
        trace.say("7E4#11 00 00 00 00 00 00 00");
        assert_eq!(events(&mut trace, "707#00").len(), 1, "{switch}");
    }
}

/// A node is the addressed slave only if it has shown all four numbers of the address.
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
    // Assigning the node-ID that a node already has causes no event.
    let mut trace = Trace::new();
    trace.say("7E5#5E 00 00 00 00 00 00 00");
    trace.say("7E4#5E 2A 00 00 00 00 00 00");
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    assert_eq!(events(&mut trace, "72A#00").len(), 1);
}

/// An address that was selected before a switch to another slave is not the address of that slave.
#[test]
fn an_lss_address_belongs_to_the_slave_that_was_selected() {
    let mut trace = Trace::new();
    select_node_63(&mut trace);
    trace.say("7E5#04 00 00 00 00 00 00 00");
    trace.say("7E5#04 01 00 00 00 00 00 00");
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    let changed = Event::NodeIdChanged { from: None, to: node(42), object: None };
    assert!(events(&mut trace, "72A#00").contains(&changed));
}
