//! Properties that are learned from the frames themselves: the period of SYNC, the rhythm and the length of PDOs, and
//! errors on the bus that silence all nodes.

use crate::traffic::{Traffic, hex};
use canvass_analyzer::findings::{Finding, Severity};

fn beats(seconds: u64) -> Traffic {
    let mut traffic = Traffic::default();
    for node in [1, 2, 3] {
        traffic.every(30 + node, seconds * 1_000, 100, |_| format!("70{node}#05"));
    }
    traffic
}

/// A queue is drained at the start: the first SYNC messages come in a burst.
#[test]
fn a_burst_of_sync_is_no_period() {
    let mut traffic = beats(10);
    for n in 0..9 {
        traffic.micros(n * 1_800, "080#");
    }
    for n in 0..490 {
        traffic.micros(36_600 + n * 20_200, "080#");
    }
    traffic.only(&[]);
}

#[test]
fn a_sync_that_changes_its_period_is_not_missing() {
    for (before, after) in [(10, 50), (50, 10), (10, 18), (20, 1_000)] {
        let mut traffic = beats(20);
        traffic.every(0, 10_000, before, |_| "080#".to_owned()).every(10_000, 20_000, after, |_| "080#".to_owned());
        let found = traffic.results().findings;
        assert!(found.iter().all(|finding| finding.rule.id != "pdo/sync-missing"), "{before} {after}: {found:#?}");
    }
}

#[test]
fn sync_that_is_missing_again_and_again() {
    let mut traffic = beats(10);
    traffic.every(0, 10_000, 20, |_| "080#".to_owned());
    for at in [3_000, 5_000, 5_040, 7_000, 7_020, 7_040] {
        traffic.silence(0x080, at, at + 1);
    }
    let found = traffic.finds("pdo/sync-missing", None, 2_980);
    assert_eq!(found.count, 4);
    assert!(found.message.contains("no SYNC for 80"), "{}", found.message);
}

/// The producer stalls, and then sends the missed SYNC messages at once.
#[test]
fn a_sync_producer_that_catches_up() {
    let mut traffic = beats(10);
    traffic.every(0, 10_000, 20, |_| "080#".to_owned()).silence(0x080, 5_000, 5_200);
    for n in 0..10 {
        traffic.micros(5_190_000 + n * 500, "080#");
    }
    traffic.finds("pdo/sync-missing", None, 4_980);
}

/// As before, after a longer stall: everything that was missed is sent at once.
#[test]
fn a_long_gap_is_not_hidden_by_catching_up() {
    for missed in [30, 60, 100] {
        let mut traffic = beats(12);
        let end = 5_000 + missed * 20;
        traffic.every(0, 12_000, 20, |_| "080#".to_owned()).silence(0x080, 5_000, end);
        for n in 0..missed {
            traffic.micros((end - 10) * 1_000 + n * 500, "080#");
        }
        let found = traffic.finds("pdo/sync-missing", None, 4_980);
        assert_eq!(found.count, 1, "{missed}");
    }
}

/// All nodes are silent while errors flood the bus.
#[test]
fn a_flood_of_errors_is_the_physical_layer() {
    let mut traffic = beats(12);
    traffic.remove(|ms, _| (5_000..9_000).contains(&ms));
    traffic.every(5_000, 9_000, 100, |_| "20000008#0000040000000000".to_owned());
    let results = traffic.results();
    assert_eq!(results.stories.len(), 1, "{:#?}", results.stories);
    let head = &results.findings[results.stories[0].head[0]];
    assert_eq!((head.rule.id, head.count, head.severity), ("capture/error-flood", 1, Severity::Error));
    assert!(head.message.starts_with("40 error frames within 3.9"), "{}", head.message);
    let lost = results.findings.iter().filter(|finding| finding.rule.id == "nodes/lost").count();
    assert_eq!(lost, 3);
}

/// A few error frames while one node is cut off are no flood: the loss of this node is reported first.
#[test]
fn few_errors_are_no_flood() {
    let mut traffic = beats(12);
    traffic.silence(0x702, 5_000, 9_000).every(5_000, 5_300, 100, |_| "20000008#0000040000000000".to_owned());
    let results = traffic.results();
    let head = &results.findings[results.stories[0].head[0]];
    assert_eq!((head.rule.id, head.node.map(|node| node.raw())), ("nodes/lost", Some(2)));
    assert!(results.findings.iter().all(|finding| finding.rule.id != "capture/error-flood"));
}

/// Node 2 sends TPDO 1 every 100 ms until 20 s.
fn stops(data: impl Fn(u64) -> String) -> Traffic {
    let mut traffic = beats(40);
    traffic.every(0, 40_000, 100, |_| "080#".to_owned()).every(2, 20_000, 100, move |n| format!("182#{}", data(n)));
    traffic
}

#[test]
fn a_pdo_that_stops_is_learned() {
    let found = stops(|_| "0102030405060708".to_owned()).finds("pdo/ended", Some(2), 19_902);
    assert_eq!(found.severity, Severity::Warning);
    assert!(found.message.contains("does not come for the last 20.0"), "{}", found.message);
    assert!(found.message.contains("before it came every 100 ms"), "{}", found.message);
    let last = found.evidence[0].record.as_ref().and_then(|record| record.frame.cob_id());
    assert_eq!((found.evidence.len(), last), (1, Some(0x182)));
}

/// Events send a PDO as often as its inhibit time allows, until its value rests.
#[test]
fn a_value_that_rests_is_no_pdo_that_stops() {
    stops(hex).only(&[]);
}

#[test]
fn a_pdo_that_stops_with_its_reason() {
    let constant = |_| "0102030405060708".to_owned();
    let mut stopped = stops(constant);
    stopped.silence(0x702, 20_000, 40_000).at(20_000, "000#8002");
    stopped.every(20_032, 25_000, 100, |_| "702#7F".to_owned()).every(25_032, 40_000, 100, |_| "702#05".to_owned());
    stopped.at(25_000, "000#0102").only(&[]);
    let mut without_sync = stops(constant);
    without_sync.silence(0x080, 20_000, 40_000).only(&["pdo/sync-missing"]);
    let mut unfed = stops(constant);
    unfed.every(1, 20_000, 100, |_| "202#0102".to_owned()).only(&[]);
    let mut several = stops(constant);
    several.every(5, 20_000, 50, |_| "183#0102".to_owned()).only(&[]);
    let mut reconfigured = stops(constant);
    reconfigured.sdo(19_950, 2, "2300180182010080", "6000180100000000").only(&[]);
}

/// The event timer is written in the capture: then the end is certain.
#[test]
fn a_pdo_with_an_event_timer_that_stops() {
    let mut traffic = stops(hex);
    traffic.remove(|ms, frame| ms < 400 && frame.cob_id() == Some(0x182));
    traffic.sdo(100, 2, "2B00180564000000", "6000180500000000").sdo(120, 2, "2F001802FE000000", "6000180200000000");
    let found = traffic.finds("pdo/ended", Some(2), 19_902);
    assert_eq!(found.severity, Severity::Error);
    assert!(found.message.contains("its event timer is 100 ms"), "{}", found.message);
}

/// A node without a heartbeat falls silent: only its PDO shows this.
#[test]
fn a_node_without_heartbeat_that_falls_silent() {
    let mut traffic = stops(|_| "0102030405060708".to_owned());
    traffic.remove(|_, frame| frame.cob_id() == Some(0x702)).at(1, "000#0102");
    let found = traffic.finds("pdo/ended", Some(2), 19_902);
    assert!(found.message.ends_with("nor does the node send anything else"), "{}", found.message);
}

#[test]
fn a_pdo_that_stays_away_for_a_while() {
    let mut traffic = stops(|_| "0102030405060708".to_owned());
    traffic.every(30_002, 40_000, 100, |_| "182#0102030405060708".to_owned());
    let found = traffic.finds("pdo/ended", Some(2), 19_902);
    assert!(found.message.contains("stayed away for 10.1"), "{}", found.message);
}

const CONSTANT: &str = "182#0102030405060708";

/// An event 10 s or more after the end of the PDO does not hide this end.
#[test]
fn a_pdo_that_stopped_before_something_else_happened() {
    let constant = |_| "0102030405060708".to_owned();
    let other = ["nodes/left-stopped", "nodes/boot-up-without-command", "nodes/state-lost", "capture/gaps"];
    let check = |traffic: &Traffic, text: &str| {
        let found = traffic.finds_among(&[&other[..], &["pdo/ended"]].concat(), "pdo/ended", Some(2), 19_902);
        assert!(found.message.contains(text), "{}", found.message);
        assert_eq!(found.severity, Severity::Warning);
    };
    let mut all_stopped = stops(constant);
    check(all_stopped.at(39_500, "000#0200"), "did not come for 19.5");
    check(&all_stopped, ", until an NMT command to the node; before it came every 100 ms");
    check(stops(constant).at(35_000, "702#00"), "until the node booted");
    let written = ("2300180182010080", "6000180100000000");
    check(stops(constant).sdo(30_000, 2, written.0, written.1), "until its parameters were written");
    // The recorder is off for half a minute.
    let mut gap = stops(constant);
    for node in [1, 2, 3] {
        gap.every(70_030 + node, 80_000, 100, |_| format!("70{node}#05"));
    }
    check(gap.every(70_000, 80_000, 100, |_| "080#".to_owned()), "until frames are missing in the capture");
    // The PDO comes again after the event.
    let mut back = stops(constant);
    back.at(30_000, "000#8002").silence(0x702, 30_000, 40_000).at(31_000, "000#0102");
    back.every(30_032, 31_000, 100, |_| "702#7F".to_owned()).every(31_032, 40_000, 100, |_| "702#05".to_owned());
    check(back.every(31_100, 40_000, 100, |_| CONSTANT.to_owned()), "did not come for 10");
}

/// The TPDO is not accused if SYNC, the RPDOs or the whole node fell silent together with it before the event.
#[test]
fn a_pdo_that_stopped_with_its_reason_before_something_else_happened() {
    let constant = |_| "0102030405060708".to_owned();
    let mut without_sync = stops(constant);
    without_sync.silence(0x080, 20_000, 40_000).at(39_500, "000#0200").only(&["pdo/sync-missing"]);
    let mut unfed = stops(constant);
    unfed.every(1, 20_000, 100, |_| "202#0102".to_owned()).at(39_500, "000#0200").only(&[]);
    let mut several = stops(constant);
    several.every(5, 20_000, 50, |_| "183#0102".to_owned()).at(39_500, "000#0200").only(&[]);
    let mut switched_off = stops(constant);
    switched_off.remove(|_, frame| frame.cob_id() == Some(0x702)).at(1, "000#0102").at(39_000, "702#00");
    switched_off.only(&["nodes/boot-up-without-command"]);
}

/// Only a write that the node accepts changes parameters, and only the parameters of one PDO.
#[test]
fn a_pdo_that_stopped_while_its_parameters_were_read() {
    for (request, response) in [
        ("4000180100000000", "4300180182010000"),
        ("2300180182010080", "8000180122000108"),
        ("2301180182020080", "6001180100000000"),
        ("2F011A0000000000", "60011A0000000000"),
    ] {
        let mut traffic = stops(|_| "0102030405060708".to_owned());
        let rules = ["pdo/ended", "sdo/aborted"];
        let found = traffic.sdo(19_950, 2, request, response).finds_among(&rules, "pdo/ended", Some(2), 19_902);
        assert!(found.message.contains("does not come for the last 20.0"), "{request}: {}", found.message);
    }
    let mut mapped = stops(|_| "0102030405060708".to_owned());
    mapped.sdo(19_950, 2, "2F001A0000000000", "60001A0000000000").only(&[]);
}

/// The encoder's own timer for TPDO 1 is written.
#[test]
fn a_timer_of_the_profile_that_is_set_to_zero() {
    let mut traffic = stops(|_| "0102030405060708".to_owned());
    traffic.sdo(40, 2, "4000100000000000", "4300100096010200").sdo(19_950, 2, "2B00620000000000", "6000620000000000");
    traffic.only(&[]);
}

/// Node 2 sends TPDO 1 every 100 ms, except from 15 s to 20 s.
fn pauses() -> Traffic {
    let mut traffic = beats(40);
    traffic.every(2, 15_000, 100, |_| CONSTANT.to_owned()).every(20_002, 40_000, 100, |_| CONSTANT.to_owned());
    traffic
}

#[test]
fn a_pause_with_its_reason() {
    pauses().finds("pdo/ended", Some(2), 14_902);
    let mut of_sync = pauses();
    of_sync.every(0, 15_000, 100, |_| "080#".to_owned()).every(20_000, 40_000, 100, |_| "080#".to_owned());
    of_sync.sdo(15_030, 1, "2306100000000000", "6006100000000000");
    of_sync.sdo(19_930, 1, "23061000A0860100", "6006100000000000").only(&["pdo/sync-missing"]);
    let mut of_rpdo = pauses();
    of_rpdo.every(0, 15_000, 100, |_| "202#0100".to_owned()).every(20_000, 40_000, 100, |_| "202#0100".to_owned());
    of_rpdo.only(&[]);
    let mut of_all = pauses();
    for node in [1, 3] {
        let frame = |_| format!("18{node}#0102030405060708");
        of_all.every(5 + node, 15_000, 100, frame).every(20_005 + node, 40_000, 100, frame);
    }
    of_all.only(&[]);
    // SYNC pauses at another time.
    let mut unexplained = pauses();
    unexplained.every(0, 25_000, 100, |_| "080#".to_owned()).every(30_000, 40_000, 100, |_| "080#".to_owned());
    unexplained.finds_among(&["pdo/ended", "pdo/sync-missing"], "pdo/ended", Some(2), 14_902);
}

/// A device that leaves its rhythm may send on events from then on.
#[test]
fn events_that_follow_a_rhythm() {
    let mut traffic = beats(100);
    traffic.every(2, 5_000, 100, |_| CONSTANT.to_owned());
    for n in 0..30 {
        traffic.at(6_100 + n * 2_900 + n * n * 7_919 % 1_400, &format!("182#{0}{0}", hex(n * n)));
    }
    traffic.only(&[]);
}

/// A device that sends its PDO from time to time, such as while it moves.
#[test]
fn a_pdo_that_comes_in_bursts() {
    let mut traffic = beats(100);
    for n in 0..6 {
        traffic.every(1_002 + n * 15_000, 6_000 + n * 15_000, 100, |_| CONSTANT.to_owned());
    }
    traffic.only(&[]);
}

#[test]
fn a_pdo_that_changes_its_length() {
    let mut traffic = stops(|_| "0102030405060708".to_owned());
    traffic.every(20_002, 40_000, 100, |_| "182#01020304".to_owned());
    let found = traffic.finds("pdo/length-changed", Some(2), 20_002);
    assert_eq!(found.count, 2);
    assert!(found.message.contains("has 4 bytes, the 200 before it had 8"), "{}", found.message);
    // A new start may bring another mapping.
    traffic.at(20_000, "702#00").silence(0x702, 20_001, 40_000).only(&[
        "nodes/boot-up-without-command",
        "nodes/heartbeat-ended",
        "nodes/lost",
    ]);
}

fn second_sender(after: u64, data: &str) -> Vec<Finding> {
    let mut traffic = beats(40);
    traffic.every(0, 40_000, 100, |_| "080#".to_owned()).every(2, 40_000, 100, |_| "182#0102030405060708".to_owned());
    traffic.every(20_002 + after, 40_000, 100, |_| format!("182#{data}"));
    traffic.only(&["bus/two-producers", "pdo/length-changed"])
}

#[test]
fn a_second_sender_of_a_pdo_is_learned() {
    for after in [2, 20, 30, 70, 90] {
        let found = second_sender(after, "1112131415161718");
        assert_eq!(found.len(), 1, "{after}: {found:#?}");
        assert_eq!((found[0].rule.id, found[0].severity), ("bus/two-producers", Severity::Warning));
        assert!(found[0].message.contains("two devices send it"), "{}", found[0].message);
    }
    let other_length = second_sender(2, "AABBCCDD");
    assert_eq!(other_length.len(), 2, "{other_length:#?}");
}

/// One device that doubles its rate is no second sender.
#[test]
fn a_doubled_rate_is_no_second_sender() {
    assert!(second_sender(50, "0102030405060708").is_empty());
}

/// TPDO 1 of node 1 with a timer of 50 ms and resting data; other frames come besides.
fn timed(others: &[(u64, &str)]) -> Traffic {
    let mut traffic = beats(20);
    traffic.every(10, 20_000, 50, |_| "181#0102".to_owned());
    for (at, frame) in others {
        traffic.at(*at, frame);
    }
    traffic
}

#[test]
fn a_pdo_that_leaves_its_rhythm_once() {
    let once = timed(&[(15_025, "181#7777")]).finds("pdo/out-of-rhythm", Some(1), 15_060);
    assert_eq!(once.severity, Severity::Info);
    let mut late = timed(&[]);
    let late = late.silence(0x181, 15_000, 15_150).finds("pdo/out-of-rhythm", Some(1), 15_160);
    assert!(
        late.severity == Severity::Info && late.message.contains("200 ms after the one before"),
        "{}",
        late.message
    );
    timed(&[]).only(&[]);
}

/// A device that rests, and then moves: events send the PDO between its timer, which goes on in its own rhythm. The timer
/// repeats the last value, or has a newer one.
#[test]
fn events_beside_a_timer_are_no_second_sender() {
    for newer in [0, 1] {
        let mut traffic = beats(20);
        traffic.every(10, 10_000, 50, |_| "181#0102".to_owned());
        for n in 0..200 {
            let value = 2 * n + 1;
            traffic.at(10_010 + n * 50, &format!("181#{:04X}", 0x200 + value));
            traffic.at(10_015 + n * 50 + n * 17 % 40, &format!("181#{:04X}", 0x200 + value + newer));
        }
        let found = traffic.results().findings;
        let told: Vec<_> = found.iter().filter(|finding| finding.severity > Severity::Info).collect();
        assert!(told.is_empty(), "{told:#?}");
    }
}

/// The other sender keeps no phase to the first one, so that the parts of the period change.
#[test]
fn a_second_sender_without_a_phase() {
    let phases = [12, 17, 9, 15, 11, 18, 10, 16, 13];
    let others: Vec<(u64, &str)> = (0..).zip(phases).map(|(n, phase)| (15_010 + n * 50 + phase, "181#7777")).collect();
    let found = timed(&others).finds("pdo/out-of-rhythm", Some(1), 15_060);
    assert!(found.severity == Severity::Warning && found.message.ends_with("two devices send it"), "{}", found.message);
}

/// SYNC every 100 ms, and RPDO 1 of node 1 at every second one. Nothing is known of its parameters.
fn stepped(but: impl Fn(u64) -> usize) -> Traffic {
    let mut traffic = beats(20);
    traffic.every(0, 20_000, 100, |_| "080#".to_owned());
    for n in 0..100 {
        for time in 0..but(n) {
            traffic.at(n * 200 + 5 + time as u64 * 30, "201#0102");
        }
    }
    traffic
}

#[test]
fn a_pdo_out_of_step_with_sync() {
    stepped(|_| 1).only(&[]);
    let left_out = stepped(|n| usize::from(n != 70)).finds("pdo/out-of-rhythm", Some(1), 14_405);
    assert!(left_out.message.contains("only after 4 SYNC messages"), "{}", left_out.message);
    let additional = stepped(|n| 1 + usize::from(n == 70)).finds("pdo/out-of-rhythm", Some(1), 14_205);
    assert!(additional.message.contains("once more after 0 SYNC messages"), "{}", additional.message);
}

/// TPDO 1 of node 9, which sends nothing else, appears in the middle of the capture.
#[test]
fn a_pdo_of_a_node_that_does_nothing_else() {
    let other = |at: u64| timed(&[(at, "189#01020304")]);
    let appears = other(15_000).finds("pdo/of-unknown-node", Some(9), 15_000);
    assert_eq!(appears.severity, Severity::Info);
    // At the start of a capture all PDOs appear.
    other(1_000).only(&[]);
    // An event-driven PDO that ends at this time may have ended by itself.
    let mut sparse = timed(&[(15_000, "189#01020304")]);
    for at in [2_000, 6_100, 7_000, 14_900] {
        sparse.at(at, &format!("282#{at:08}"));
    }
    assert_eq!(sparse.finds("pdo/of-unknown-node", Some(9), 15_000).severity, Severity::Info);
    // It takes the place of another one.
    let mut moved = beats(20);
    moved.every(10, 12_000, 50, |_| "181#0102".to_owned()).every(12_010, 20_000, 50, |_| "182#0102".to_owned());
    moved.remove(|_, frame| frame.cob_id() == Some(0x702));
    let among = ["pdo/of-unknown-node", "pdo/ended"];
    let moved = moved.finds_among(&among, "pdo/of-unknown-node", Some(2), 12_010);
    assert!(
        moved.severity == Severity::Warning && moved.message.contains("TPDO 1 of node 1 ended"),
        "{}",
        moved.message
    );
}
