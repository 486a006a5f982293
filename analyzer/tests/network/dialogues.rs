//! Dialogues of layer setting, and events from the states and errors that nodes show.

use crate::trace::Trace;
use crate::{events, node};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::network::{Cause, Emergency, Event, Exchange, StateChange};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::Emcy;
use canvass_analyzer::wire::error_control::State;
use canvass_traces::{Duration, Timestamp};

fn asked(unanswered: bool) -> Event {
    Event::LayerSetting(Exchange::Request { unanswered })
}

/// A missing answer to a request of LSS or LMT is reported with the next request. Services without an answer are not
/// reported.
#[test]
fn a_request_without_its_answer_is_told_with_the_next() {
    let answered = [
        "7E5#11 05 00 00 00 00 00 00",
        "7E5#13 00 03 00 00 00 00 00",
        "7E5#17 00 00 00 00 00 00 00",
        "7E5#5A 00 00 00 00 00 00 00",
        "7E5#5D 00 00 00 00 00 00 00",
        "7E5#5E 00 00 00 00 00 00 00",
        // The last of the four numbers of an LSS address.
        "7E5#43 A5 00 00 00 00 00 00",
    ];
    for request in answered {
        let mut trace = Trace::new();
        assert_eq!(events(&mut trace, request), [asked(false)], "{request}");
        assert_eq!(events(&mut trace, request), [asked(true)], "{request}");
    }
    let silent = ["7E5#04 01", "7E5#40 13 00 00 00 00 00 00", "7E5#42 66 00 00 00 00 00 00", "7E5#4C"];
    for request in silent {
        let mut trace = Trace::new();
        let request =
            format!("{request} {}", "00 ".repeat(10)).split_whitespace().take(8).collect::<Vec<_>>().join(" ");
        events(&mut trace, &request);
        assert_eq!(events(&mut trace, &request), [asked(false)], "{request}");
    }
}

#[test]
fn several_slaves_may_answer_one_request_and_none_unasked() {
    let mut trace = Trace::new();
    let unasked = Event::LayerSetting(Exchange::Unasked);
    assert_eq!(events(&mut trace, "7E4#50 00 00 00 00 00 00 00"), [unasked]);
    trace.say("7E5#4C 00 00 00 00 00 00 00");
    for millis in 1..=3 {
        let answer = Event::LayerSetting(Exchange::Response(Duration::from_millis(millis)));
        assert_eq!(events(&mut trace, "7E4#50 00 00 00 00 00 00 00"), [answer]);
    }
    // All slaves have answered, so the next request reports no missing answer.
    trace.say("7E5#5E 00 00 00 00 00 00 00");
    trace.say("7E4#5E 05 00 00 00 00 00 00");
    assert_eq!(events(&mut trace, "7E5#5E 00 00 00 00 00 00 00"), [asked(false)]);
}

/// Table 0 of LSS: index 3 is 250 kbit/s (CiA 305).
#[test]
fn a_bit_rate_acts_when_it_was_confirmed_and_activated() {
    let activated = |answer: Option<&str>, setting: &str| {
        let mut trace = Trace::new();
        trace.say(setting);
        answer.into_iter().for_each(|answer| drop(trace.say(answer)));
        let all = events(&mut trace, "7E5#15 E8 03 00 00 00 00 00");
        all.into_iter().find(|event| matches!(event, Event::BitRateChanged { .. })).unwrap()
    };
    let changed = |bit_rate| Event::BitRateChanged { node: None, bit_rate, delay: Duration::from_millis(1_000) };
    let (set, good, bad) =
        ("7E5#13 00 03 00 00 00 00 00", "7E4#13 00 00 00 00 00 00 00", "7E4#13 01 00 00 00 00 00 00");
    assert_eq!(activated(Some(good), set), changed(Some(250_000)));
    assert_eq!(activated(Some(bad), set), changed(None));
    assert_eq!(activated(None, set), changed(None));
    // The code of another table than CiA's has no known bit rate.
    assert_eq!(activated(Some(good), "7E5#13 80 03 00 00 00 00 00"), changed(None));
}

/// The node-ID that a slave reports in configuration is its former node-ID. The report of a slave that has left
/// configuration does not count.
#[test]
fn the_node_id_that_was_told_is_the_one_before() {
    let mut trace = Trace::new();
    trace.say("7E5#5E 00 00 00 00 00 00 00");
    trace.say("7E4#5E 09 00 00 00 00 00 00");
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    trace.say("7E5#04 00 00 00 00 00 00 00");
    let changed = Event::NodeIdChanged { from: Some(node(9)), to: node(42), object: None };
    assert!(events(&mut trace, "72A#00").contains(&changed));

    let mut trace = Trace::new();
    trace.say("7E5#5E 00 00 00 00 00 00 00");
    trace.say("7E4#5E 09 00 00 00 00 00 00");
    trace.say("7E5#04 00 00 00 00 00 00 00");
    trace.say("7E5#04 01 00 00 00 00 00 00");
    trace.say("7E5#11 2A 00 00 00 00 00 00");
    trace.say("7E4#11 00 00 00 00 00 00 00");
    let changed = Event::NodeIdChanged { from: None, to: node(42), object: None };
    assert!(events(&mut trace, "72A#00").contains(&changed), "it was another slave");
}

#[test]
fn a_command_to_all_changes_the_nodes_that_are_known() {
    let mut trace = Trace::new();
    trace.say("705#00");
    trace.say("707#00");
    let to = |id, state| {
        let from = Some(State::PRE_OPERATIONAL);
        Event::StateChanged(node(id), StateChange { from, to: state, cause: Cause::Command })
    };
    assert_eq!(events(&mut trace, "000#01 00"), [to(5, State::OPERATIONAL), to(7, State::OPERATIONAL)]);
    assert_eq!(events(&mut trace, "000#01 00"), [], "they are operational already");
    trace.say("000#80 05");
    assert_eq!(events(&mut trace, "000#02 05"), [to(5, State::STOPPED)]);
    // 128 is no node-ID.
    assert_eq!(events(&mut trace, "000#02 80"), []);
}

#[test]
fn a_state_is_news_once() {
    let mut trace = Trace::new();
    let change = |from, to| Event::StateChanged(node(5), StateChange { from, to, cause: Cause::ErrorControl });
    assert_eq!(events(&mut trace, "705#05"), [change(None, State::OPERATIONAL)]);
    assert_eq!(events(&mut trace, "705#05"), []);
    assert_eq!(events(&mut trace, "705#7F"), [change(Some(State::OPERATIONAL), State::PRE_OPERATIONAL)]);
}

/// The age of an error counts from its first message, until the error ends or the node restarts.
#[test]
fn an_error_has_an_age() {
    let mut trace = Trace::new();
    let told = |bytes: [u8; 8], since: Option<u64>| {
        let emcy = Emcy::read(&bytes).unwrap();
        Event::Emergency(node(5), Emergency { emcy, since: since.map(|ms| Timestamp((1_000 + ms) * 1_000_000)) })
    };
    let (lost, hot, gone) = ([0x30, 0x81, 0x11, 0, 0, 0, 0, 0], [0, 0x42, 0x19, 0, 0, 0, 0, 0], [0; 8]);
    assert_eq!(events(&mut trace, "085#30 81 11 00 00 00 00 00"), [told(lost, Some(1))]);
    assert_eq!(events(&mut trace, "085#00 42 19 00 00 00 00 00"), [told(hot, Some(1))]);
    assert_eq!(events(&mut trace, "085#00 00 00 00 00 00 00 00"), [told(gone, Some(1))]);
    assert_eq!(events(&mut trace, "085#00 00 00 00 00 00 00 00"), [told(gone, None)]);
    assert_eq!(events(&mut trace, "085#00 42 19 00 00 00 00 00"), [told(hot, Some(5))]);
    trace.say("705#00");
    assert_eq!(events(&mut trace, "085#30 81 11 00 00 00 00 00"), [told(lost, Some(7))]);
}

/// Before V4 of CiA 301 an EMCY without data was the boot-up message; devices between the versions send both.
#[test]
fn two_kinds_of_boot_up_are_one_start() {
    let started = |from| {
        let change = StateChange { from, to: State::PRE_OPERATIONAL, cause: Cause::BootUp };
        Event::StateChanged(node(5), change)
    };
    let mut trace = Trace::new();
    assert_eq!(events(&mut trace, "085#"), [started(None)]);
    assert_eq!(events(&mut trace, "705#00"), []);
    // A further boot-up of either kind is another start.
    assert_eq!(events(&mut trace, "705#00"), [started(Some(State::PRE_OPERATIONAL))]);
    assert_eq!(events(&mut trace, "705#00"), [started(Some(State::PRE_OPERATIONAL))]);
    // An empty EMCY more than a second later is another start too.
    trace.now += Duration::from_millis(1_001);
    assert_eq!(events(&mut trace, "085#"), [started(Some(State::PRE_OPERATIONAL))]);
}

/// A message of a transfer has the object of the transfer.
#[test]
fn a_transfer_names_its_object() {
    let mut trace = Trace::new();
    let said = trace.say("605#40 18 10 01 00 00 00 00");
    assert_eq!(said.decoded.object, Some(Multiplexer::new(0x1018, 1)));
    let said = trace.say("585#43 18 10 01 13 00 00 00");
    assert_eq!(
        (said.decoded.object, said.decoded.event),
        (Some(Multiplexer::new(0x1018, 1)), Some(Event::TransferEnded))
    );
}
