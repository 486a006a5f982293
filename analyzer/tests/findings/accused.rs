//! Situations in which a node must not be accused, each beside the fault that looks like this situation.

use crate::traffic::Traffic;
use canvass_analyzer::findings::{Finding, Severity};

fn master(seconds: u64) -> Traffic {
    let mut traffic = Traffic::default();
    traffic.every(50, seconds * 1_000, 500, |_| "701#05".to_owned());
    traffic
}

fn rules(findings: &[Finding]) -> Vec<&'static str> {
    findings.iter().map(|finding| finding.rule.id).collect()
}

/// A server answers one request four times.
#[test]
fn a_server_that_repeats_itself_is_one_device() {
    let mut traffic = Traffic::default();
    traffic.at(0, "603#4000100000000000");
    for us in [1_000, 1_500, 2_000, 2_500] {
        traffic.micros(us, "583#4300100092010200");
    }
    let found = traffic.only(&["sdo/protocol-violation"]);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].message, "the server repeats its answer (1000h:00)");
    // Two answers to each of several requests come from two devices.
    let mut two = Traffic::default();
    for n in 0..4 {
        let ms = 1_000 + n * 100;
        two.at(ms, "603#4000100000000000").at(ms + 1, "583#4300100092010200").at(ms + 3, "583#4300100092010200");
    }
    assert!(rules(&two.results().findings).contains(&"bus/duplicate-node-id"));
}

/// A server answers the client's abort, and then the request too.
#[test]
fn an_answered_abort_is_no_second_device() {
    let mut traffic = master(10);
    traffic.at(1_000, "703#00");
    for n in 0..4 {
        let ms = 2_000 + n * 1_000;
        traffic.at(ms, "603#4000100000000000").at(ms + 500, "603#8000100000000405");
        traffic.at(ms + 503, "583#8000100001000405").at(ms + 520, "583#4300100092010200");
    }
    let found = traffic.results().findings;
    assert!(!rules(&found).contains(&"bus/duplicate-node-id"), "{found:#?}");
}

/// Node 3 falls out of operational after an EMCY; the master starts it again without a reset.
fn falls_out(started: bool) -> Traffic {
    let mut traffic = master(110);
    traffic.at(500, "703#00").at(1_000, "000#0103");
    for n in 0..1_100_u64 {
        let ms = 1_002 + n * 100;
        let fallen = ms > 20_000 && (ms - 1_002) % 20_000 > 18_999;
        traffic.at(ms, if fallen { "703#7F" } else { "703#05" });
    }
    for n in 1..=5 {
        let ms = n * 20_000;
        traffic.at(ms, "083#3081110000000000").at(ms + 1_500, "083#0000000000000000");
        if started {
            traffic.at(ms + 1_000, "000#0103");
        }
    }
    traffic
}

#[test]
fn a_node_that_is_started_again_after_each_error_is_one_device() {
    let results = falls_out(true).results();
    let first = &results.findings[results.stories[0].head[0]];
    assert_eq!((first.rule.id, first.count), ("emcy/raised", 5), "{:#?}", results.stories);
    assert!(!rules(&results.findings).contains(&"bus/duplicate-node-id"));
    // Nobody commands the change back: two devices alternate.
    assert!(rules(&falls_out(false).results().findings).contains(&"bus/duplicate-node-id"));
}

#[test]
fn a_master_that_resets_all_is_not_missed() {
    let mut traffic = Traffic::default();
    traffic.at(0, "701#00").micros(300, "000#8200").at(1, "702#00").at(10_500, "080#").at(11_000, "080#");
    let found = traffic.results().findings;
    assert!(found.iter().all(|finding| finding.node.is_none()), "{found:#?}");
    // A reset that names the node is meant for it.
    let mut named = Traffic::default();
    named.at(0, "701#00").at(1, "702#00").at(20, "000#8201").every(500, 11_000, 500, |_| "702#7F".to_owned());
    named.finds("nodes/no-boot-up", Some(1), 20);
}

/// The master stops all nodes, and goes on sending its own heartbeat.
#[test]
fn a_master_that_stops_all_goes_on() {
    for state in ["05", "7F"] {
        let mut traffic = Traffic::default();
        traffic.every(50, 30_000, 500, |_| format!("701#{state}"));
        traffic.at(100, "702#00").at(400, "000#0102").every(600, 10_000, 500, |_| "702#05".to_owned());
        traffic.at(10_001, "000#0200").every(10_100, 30_000, 500, |_| "702#04".to_owned());
        traffic.only(&[]);
    }
}

/// No standard says how fast a node must reach the commanded state.
#[test]
fn a_node_that_starts_slowly_obeys() {
    let slow = |until: u64| {
        let mut traffic = master(30);
        traffic.at(100, "703#00").every(202, until, 100, |_| "703#7F".to_owned()).at(10_000, "000#0103");
        traffic.every(until + 2, 30_000, 100, |_| "703#05".to_owned());
        traffic
    };
    for late in [250, 700, 1_500, 4_000] {
        slow(10_000 + late).only(&[]);
    }
    let found = slow(17_000).finds("nodes/command-not-obeyed", Some(3), 10_000);
    assert_eq!(found.severity, Severity::Error);
}

#[test]
fn a_node_that_does_not_obey_before_the_next_command() {
    let mut traffic = master(30);
    traffic.at(100, "703#00").every(202, 30_000, 100, |_| "703#7F".to_owned());
    traffic.at(10_000, "000#0103").at(11_000, "000#8003");
    traffic.finds("nodes/command-not-obeyed", Some(3), 10_000);
}

#[test]
fn requests_between_reset_and_boot_up_are_too_early() {
    let mut traffic = master(20);
    traffic.at(100, "702#00").every(300, 10_000, 100, |_| "702#7F".to_owned()).at(10_000, "000#8102");
    traffic.at(10_300, "602#4001100000000000").at(10_800, "602#8001100000000405");
    traffic.at(12_000, "702#00").every(12_100, 20_000, 100, |_| "702#7F".to_owned());
    let found = traffic.finds_among(&["sdo/too-early", "sdo/aborted"], "sdo/too-early", Some(2), 10_300);
    assert!(found.message.contains("after the reset and 1.69"), "{}", found.message);
    // After the boot-up the node must answer.
    let mut late = traffic.clone();
    late.remove(|ms, frame| frame.cob_id() == Some(0x602) && ms > 0);
    late.at(13_000, "602#4001100000000000").finds("sdo/unanswered", Some(2), 13_000);
}

/// Four requests before the boot-up, and the four answers from the node's queue after it.
#[test]
fn requests_before_the_first_boot_up_are_too_early() {
    let mut traffic = Traffic::default();
    traffic.every(0, 6_000, 100, |_| "080#".to_owned());
    for ms in [10, 1_010, 2_010, 3_010] {
        traffic.at(ms, "620#4000100000000000").at(ms + 500, "620#8000100000000405");
    }
    traffic.at(4_200, "720#00").at(4_202, "0A0#1081110000000000").at(4_300, "0A0#0000000000000000");
    for ms in [4_203, 4_204, 4_205, 4_206] {
        traffic.at(ms, "5A0#4300100092010200");
    }
    let rules = ["sdo/too-early", "sdo/aborted", "emcy/raised"];
    let found = traffic.finds_among(&rules, "sdo/too-early", Some(32), 10);
    assert_eq!((found.count, traffic.results().stories.len()), (4, 1));
    assert!(found.message.contains("before the node's first boot-up message, the first of 4"), "{}", found.message);
}

/// The device sends its boot-up message twice at each power-on.
#[test]
fn a_boot_up_that_is_sent_twice_is_one_start() {
    let mut traffic = master(60);
    for start in [1_000, 20_000, 40_000] {
        traffic.at(start, "703#00").at(start + 120, "703#00");
        traffic.every(start + 500, start + 15_000, 500, |_| "703#7F".to_owned());
    }
    let results = traffic.results();
    let restarts: Vec<_> = results.findings.iter().filter(|found| found.rule.id.contains("boot-up")).collect();
    assert_eq!(restarts.iter().map(|found| found.count).sum::<u64>(), 2, "{restarts:#?}");
    assert!(!rules(&results.findings).contains(&"bus/duplicate-node-id"));
    assert!(!rules(&results.findings).contains(&"nodes/repeated-resets"));
    let twice = results.findings.iter().find(|found| found.rule.id == "nodes/starts-twice").unwrap();
    assert_eq!((twice.count, twice.severity), (3, Severity::Info));
}

#[test]
fn unanswered_requests_are_told_although_the_node_speaks_later() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "606#4005100000000000").at(2_000, "606#4005100000000000").at(5_000, "706#7F");
    let found = traffic.finds("sdo/unanswered", Some(6), 1_000);
    assert!(found.message.contains("the node sends its first message 3.99"), "{}", found.message);
}

/// The answer comes on the CAN-ID of the requests.
#[test]
fn an_answer_on_the_wrong_can_id() {
    let mut traffic = Traffic::default();
    for ms in [1_000, 2_000] {
        traffic.at(ms, "606#4005100000000000").at(ms + 2, "606#4305100080000000");
    }
    traffic.at(5_000, "706#7F");
    let found = traffic.finds("sdo/unanswered", Some(6), 1_000);
    assert!(found.message.contains("looks like the answer followed on the request's own CAN-ID"), "{}", found.message);
}

#[test]
fn repeated_requests_say_whether_an_answer_came() {
    let repeated = |answered: bool| {
        let mut traffic = Traffic::default();
        traffic.at(500, "706#7F").at(1_000, "606#4005100000000000").at(1_400, "606#4005100000000000");
        if answered {
            traffic.at(1_405, "586#4305100080000000");
        }
        traffic.at(5_000, "706#7F");
        let found = traffic.results().findings;
        found.into_iter().find(|finding| finding.rule.id == "sdo/retries").unwrap().message
    };
    assert_eq!(repeated(true), "1 request was repeated before an answer came");
    assert_eq!(repeated(false), "1 request was repeated and no answer came");
}

#[test]
fn a_refused_store_is_the_refusal_only() {
    let mut traffic = Traffic::default();
    traffic.at(0, "7E5#0401000000000000").at(100, "7E5#110A000000000000").at(102, "7E4#1100000000000000");
    traffic.at(200, "7E5#1700000000000000").at(202, "7E4#1701000000000000").at(300, "7E5#0400000000000000");
    traffic.finds("lss/refused", None, 202);
}

/// A node leaves requests unanswered and sends its first message later. A boot-up after a reset does not make up for
/// the missing answers.
#[test]
fn a_later_boot_up_does_not_answer() {
    let mut traffic = Traffic::default();
    traffic.at(1_000, "606#4005100000000000").at(2_500, "606#4005100000000000").at(5_000, "706#7F");
    traffic.at(7_000, "000#8106").at(7_500, "706#00");
    traffic.finds("sdo/unanswered", Some(6), 1_000);
}

/// Node 2 goes on after a reset without a boot-up. 100 s later it is lost: requests to it then do not come too early.
#[test]
fn a_node_that_goes_on_after_a_reset_is_there() {
    let mut traffic = master(110);
    traffic.at(1_000, "000#8202").every(1_200, 100_000, 100, |_| "702#05".to_owned());
    for ms in [101_000, 104_000] {
        traffic.at(ms, "602#4000100000000000");
    }
    traffic.at(106_000, "702#00");
    let found = traffic.results().findings;
    assert!(!rules(&found).contains(&"sdo/too-early"), "{found:#?}");
    assert!(rules(&found).contains(&"sdo/unanswered"), "{found:#?}");
}

/// A node that starts again and again from its first frame on is not one that sends its boot-up message twice.
#[test]
fn a_loop_of_starts_is_no_boot_up_that_is_sent_twice() {
    let mut traffic = master(20);
    for n in 0..8 {
        traffic.at(2_000 + 400 * n, "702#00");
    }
    let found = traffic.results().findings;
    assert!(rules(&found).contains(&"nodes/repeated-resets"), "{found:#?}");
}

/// Node 3 is plugged in long after the command to all nodes, which it did not hear.
#[test]
fn a_node_that_comes_late_has_heard_no_command() {
    let mut traffic = master(60);
    traffic.at(1_000, "000#0100").every(40_020, 45_000, 500, |_| "703#7F".to_owned());
    traffic.at(44_600, "000#0103").every(45_020, 60_000, 500, |_| "703#05".to_owned());
    let found = traffic.results().findings;
    assert!(!rules(&found).contains(&"nodes/command-not-obeyed"), "{found:#?}");
}

/// A few error frames among many good frames disturb nobody.
#[test]
fn errors_among_good_frames_are_no_flood() {
    let mut traffic = master(20);
    traffic.every(1_000, 15_000, 5, |_| "181#0102030405060708".to_owned());
    traffic.every(5_001, 11_000, 400, |_| "20000008#0000040000000000".to_owned());
    let found = traffic.results().findings;
    assert!(!rules(&found).contains(&"capture/error-flood"), "{found:#?}");
}

/// The supply of node 2 dips after the errors have ended: its EMCY message and its restart have another cause.
#[test]
fn what_comes_after_a_flood_is_not_all_its_effect() {
    let mut traffic = master(60);
    traffic.every(20, 27_800, 200, |_| "702#05".to_owned()).at(27_850, "082#1031010000000000");
    traffic.every(20_000, 23_300, 100, |_| "20000008#0000040000000000".to_owned());
    traffic.at(30_500, "702#00").every(30_600, 60_000, 100, |_| "702#7F".to_owned());
    let results = traffic.results();
    let is = |at: usize, rule: &str| results.findings[at].rule.id == rule;
    let flood = results.stories.iter().find(|story| is(story.head[0], "capture/error-flood")).unwrap();
    for other in ["emcy/raised", "nodes/boot-up-without-command"] {
        assert!(!flood.all().any(|at| is(at, other)), "{other}: {:#?}", results.stories);
    }
}
