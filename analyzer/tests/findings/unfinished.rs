//! SDO transfers that are begun and not finished, messages with reserved bits, violations with their aborts; nodes that
//! are left stopped or in LSS configuration; and findings that are not the effect of others.

use crate::traffic::{Traffic, shown};
use canvass_analyzer::findings::{Finding, Results, Severity};

fn frames(rows: &[(u64, &str)]) -> Traffic {
    let mut traffic = Traffic::default();
    for (ms, text) in rows {
        traffic.at(*ms, text);
    }
    traffic
}

fn of<'a>(results: &'a Results, rule: &str) -> Vec<&'a Finding> {
    results.findings.iter().filter(|finding| finding.rule.id == rule).collect()
}

#[track_caller]
fn head(results: &Results) -> (&'static str, Option<u8>) {
    let first = &results.findings[results.stories[0].head[0]];
    (first.rule.id, first.node.map(|node| node.raw()))
}

#[test]
fn an_upload_that_the_client_abandons() {
    let traffic = frames(&[
        (0, "604#4000400000000000"),
        (1, "584#4100400014000000"),
        (5_000, "604#4001400000000000"),
        (5_001, "584#4B01400034120000"),
    ]);
    let found = traffic.finds("sdo/unfinished", Some(4), 0);
    assert_eq!(found.severity, Severity::Warning);
    assert!(found.message.starts_with("upload of 4000h:00 left with 0 of 20 bytes read: another"), "{}", found.message);
}

#[test]
fn a_download_that_the_client_abandons() {
    let traffic = frames(&[
        (0, "604#2100200014000000"),
        (1, "584#6000200000000000"),
        (10, "604#0041424344454647"),
        (11, "584#2000000000000000"),
        (500, "604#4001400000000000"),
        (501, "584#4B01400034120000"),
    ]);
    let found = traffic.finds("sdo/unfinished", Some(4), 0);
    assert!(found.message.contains("7 of 20 bytes written"), "{}", found.message);
}

#[test]
fn a_transfer_that_is_left_open() {
    let rows = [
        (0, "604#4008100000000000"),
        (1, "584#4108100014000000"),
        (10, "604#6000000000000000"),
        (11, "584#0041424344454647"),
    ];
    let mut traffic = frames(&rows);
    traffic.every(500, 9_000, 500, |_| "704#05".to_owned());
    let found = traffic.finds("sdo/unfinished", Some(4), 0);
    assert!(found.message.contains("7 of 20 bytes read: nothing follows for 8.4"), "{}", found.message);
    assert_eq!(found.evidence.len(), 2);
    // A capture may end in the middle of a transfer.
    frames(&rows).only(&[]);
}

#[test]
fn a_block_upload_that_is_abandoned() {
    let traffic = frames(&[
        (0, "604#A40810007F000000"),
        (1, "584#C608100015000000"),
        (2, "604#A300000000000000"),
        (3, "584#0141424344454647"),
        (4, "584#0248495051525354"),
        (5, "584#8355565758595A5B"),
        (5_000, "604#4001400000000000"),
        (5_001, "584#4B01400034120000"),
    ]);
    let found = traffic.finds("sdo/unfinished", Some(4), 0);
    let text = "upload of 1008h:00 left with 0 of 21 bytes read and confirmed, 21 more in a block without confirmation";
    assert!(found.message.starts_with(text), "{}", found.message);
}

/// A node that is reset in the middle of a transfer has not left it.
#[test]
fn a_reset_ends_a_transfer() {
    let mut traffic = frames(&[(0, "604#4008100000000000"), (1, "584#4108100014000000"), (100, "000#8104")]);
    traffic.at(300, "704#00").every(500, 9_000, 500, |_| "704#7F".to_owned()).only(&[]);
}

#[test]
fn reserved_bits_are_marked() {
    let results = frames(&[
        (0, "601#480D21020A000000"),
        (1, "581#480D210290010000"),
        (100, "601#200320020A000000"),
        (101, "581#6003200200000000"),
        (200, "601#430D210200000000"),
        (201, "581#430D210290010000"),
        (300, "601#2C0C200001000000"),
        (301, "581#600C200000000000"),
    ])
    .results();
    let texts: Vec<&str> = of(&results, "sdo/reserved-bits").iter().map(|finding| finding.message.as_str()).collect();
    assert_eq!(
        texts,
        [
            "client: command byte 48h has reserved bits set, 40h is right (210Dh:02)",
            "server: command byte 48h counts unused bytes, but announces no value (210Dh:02)",
            "client: command byte 20h announces no value, but bytes 4 to 7 are not 0 (2003h:02)",
            "client: command byte 43h has reserved bits set, 40h is right (210Dh:02)",
            "client: command byte 2Ch counts unused bytes, but announces no value (200Ch:00)",
        ]
    );
    assert_eq!(head(&results), ("sdo/reserved-bits", Some(1)));
}

#[test]
fn right_command_bytes_are_not_marked() {
    let mut traffic = frames(&[(0, "601#40000000000000")]);
    traffic.remove(|_, _| true);
    for (n, command) in ["2F", "2B", "27", "23", "22"].iter().enumerate() {
        traffic.sdo(100 + n as u64 * 10, 1, &format!("{command}00200000000000"), "6000200000000000");
    }
    for (n, command) in ["4F", "4B", "47", "43", "42"].iter().enumerate() {
        traffic.sdo(200 + n as u64 * 10, 1, "4000200000000000", &format!("{command}00200000000000"));
    }
    traffic.only(&[]);
}

/// A wrong CRC, and the abort for it.
#[test]
fn a_violation_comes_before_its_abort() {
    let results = frames(&[
        (0, "605#A40A10007F000000"),
        (2, "585#C60A10000A000000"),
        (4, "605#A300000000000000"),
        (6, "585#0156312E322E332D"),
        (8, "585#8272633100000000"),
        (10, "605#A2027F0000000000"),
        (12, "585#D1F3620000000000"),
        (14, "605#800A100004000405"),
    ])
    .results();
    assert_eq!((head(&results), results.stories.len()), (("sdo/protocol-violation", Some(5)), 1));
    assert!(of(&results, "sdo/protocol-violation")[0].message.contains("CRC 62F3h does not match"));
}

/// Node 2 is told to stop at 20 s; nodes 1 and 3 go on.
fn stopped(command: &str, state: &str) -> Traffic {
    let mut traffic = Traffic::default();
    for node in [1, 3] {
        traffic.every(30 + node, 40_000, 100, |_| format!("70{node}#05"));
    }
    traffic.every(32, 20_000, 100, |_| "702#05".to_owned()).every(20_032, 40_000, 100, |_| format!("702#{state}"));
    traffic.every(2, 20_000, 100, |_| "182#0102030405060708".to_owned()).at(20_000, command);
    traffic
}

#[test]
fn a_node_that_is_left_stopped() {
    for (command, state) in [("000#0202", "04"), ("000#8002", "7F")] {
        let found = stopped(command, state).finds("nodes/left-stopped", Some(2), 20_000);
        assert!(found.message.contains("not started again in the 19.9"), "{}", found.message);
        assert!(found.message.ends_with("ended with it: TPDO 1 (every 100 ms)"), "{}", found.message);
    }
    let mut started = stopped("000#0202", "04");
    started.silence(0x702, 30_000, 40_000).at(30_000, "000#0102").every(30_032, 40_000, 100, |_| "702#05".to_owned());
    started.only(&[]);
}

/// A node that still sends PDOs after the stop command is reported for PDOs outside operational, and not as left
/// stopped.
#[test]
fn a_node_whose_pdos_go_on_is_not_stopped() {
    let mut traffic = stopped("000#0202", "04");
    traffic.every(20_002, 40_000, 100, |_| "182#0102030405060708".to_owned());
    let found = traffic.results().findings;
    assert!(found.iter().all(|found| found.rule.id != "nodes/left-stopped"), "{found:#?}");
    assert!(found.iter().any(|found| found.rule.id == "nodes/pdo-outside-operational"), "{found:#?}");
}

/// A master, which goes on, stops its slaves one after the other: the machine is switched off.
#[test]
fn a_machine_that_is_stopped_node_by_node() {
    let mut traffic = Traffic::default();
    traffic.every(31, 40_000, 100, |_| "701#05".to_owned());
    for node in [2, 3, 4] {
        let stop = 20_000 + 500 * node;
        traffic.every(30 + node, stop, 100, |_| format!("70{node}#05")).at(stop, &format!("000#020{node}"));
        traffic.every(stop + 30 + node, 40_000, 100, |_| format!("70{node}#04"));
    }
    traffic.only(&[]);
    // Nodes 2 and 3 are stopped, and a second slave goes on.
    let mut partly = traffic.clone();
    partly.every(35, 40_000, 100, |_| "705#05".to_owned());
    let found = partly.only(&["nodes/left-stopped"]);
    assert_eq!(found.len(), 3, "{found:#?}");
}

/// Node 2 is stopped, is operational again by a command that the capture lacks, and is stopped again at the end.
#[test]
fn a_node_that_was_started_by_an_unseen_command_is_not_left() {
    let mut traffic = stopped("000#0202", "04");
    traffic.silence(0x702, 24_000, 38_000).every(24_032, 38_000, 100, |_| "702#05".to_owned());
    let found = traffic.results().findings;
    assert!(found.iter().all(|found| found.rule.id != "nodes/left-stopped"), "{found:#?}");
}

/// Node 2 leaves operational and comes back; only in one of the captures a command starts it.
#[test]
fn commands_that_the_capture_lacks() {
    for seen in [false, true] {
        let mut traffic = Traffic::default();
        traffic.every(31, 40_000, 100, |_| "701#05".to_owned());
        for (from, to, state) in [(32, 20_000, "05"), (20_032, 23_000, "7F"), (23_032, 40_000, "05")] {
            traffic.every(from, to, 100, |_| format!("702#{state}"));
        }
        if seen {
            traffic.at(23_000, "000#0102");
        }
        let found = traffic.finds("nodes/state-lost", Some(2), 20_032);
        assert_eq!(found.severity, if seen { Severity::Error } else { Severity::Warning }, "{}", found.message);
        assert_eq!(found.message.ends_with("commands may be missing in the capture"), !seen, "{}", found.message);
    }
}

/// All nodes are stopped at the end: the machine is switched off.
#[test]
fn a_machine_that_is_stopped() {
    let mut traffic = stopped("000#0200", "04");
    for node in [1, 3] {
        traffic.silence(0x700 + node, 20_000, 40_000).every(20_030, 40_000, 100, |_| format!("70{node}#04"));
    }
    traffic.only(&[]);
}

fn configured_by_lss(left: bool) -> Results {
    let mut traffic = Traffic::default();
    for node in [2, 4] {
        traffic.every(node, 60_000, 500, |_| format!("70{node}#05"));
    }
    traffic.every(3, 20_510, 500, |_| "703#05".to_owned()).at(20_000, "7E5#0401000000000000");
    traffic.at(20_100, "7E5#5E00000000000000").at(20_102, "7E4#5E03000000000000").at(20_500, "000#8103");
    if left {
        for ms in [25_000, 30_000] {
            traffic.at(ms, "603#4000100000000000").at(ms + 1_000, "603#8000100000000405");
        }
    } else {
        traffic.at(20_200, "7E5#0400000000000000").at(21_000, "703#00");
        traffic.every(21_500, 60_000, 500, |_| "703#7F".to_owned());
    }
    traffic.results()
}

#[test]
fn a_slave_that_is_left_in_configuration() {
    let results = configured_by_lss(true);
    assert_eq!(head(&results), ("lss/left-in-configuration", Some(3)), "{:#?}", results.stories);
    assert_eq!(results.stories.len(), 1, "{:#?}", results.findings.iter().map(shown).collect::<Vec<_>>());
    assert!(configured_by_lss(false).findings.is_empty());
}

/// Fastscan finds a slave, which is then in configuration, and is reset without being configured.
#[test]
fn a_slave_that_fastscan_leaves_in_configuration() {
    for left in [true, false] {
        let mut traffic = Traffic::default();
        traffic.every(2, 60_000, 500, |_| "702#05".to_owned());
        for (n, request) in
            ["5100000000800000", "5113000000000001", "5124000000000102", "5135000000000203"].iter().enumerate()
        {
            traffic.at(20_000 + 20 * n as u64, &format!("7E5#{request}")).at(20_005 + 20 * n as u64, "7E4#4F");
        }
        traffic.at(20_080, "7E5#5146000000000300").at(20_085, "7E4#4F00000000000000");
        if !left {
            traffic.at(20_100, "7E5#0400000000000000");
        }
        traffic.remove(|_, frame| frame.id().as_standard() == Some(0x7E4) && frame.bytes().len() < 8);
        let found = traffic.results().findings;
        let is_left = found.iter().any(|found| found.rule.id == "lss/left-in-configuration");
        assert_eq!(is_left, left, "{found:#?}");
    }
}

/// A slave gets another node-ID, and its supply is switched: it is in waiting again.
#[test]
fn a_slave_that_starts_anew_is_not_in_configuration() {
    let mut traffic = Traffic::default();
    traffic.every(2, 60_000, 500, |_| "702#05".to_owned()).every(3, 12_000, 500, |_| "703#7F".to_owned());
    traffic.at(5_000, "7E5#0401000000000000").at(5_100, "7E5#5E00000000000000").at(5_102, "7E4#5E03000000000000");
    traffic.at(5_200, "7E5#1105000000000000").at(5_202, "7E4#1100000000000000");
    traffic.at(5_300, "7E5#1700000000000000").at(5_302, "7E4#1700000000000000");
    traffic.at(15_000, "705#00").every(15_500, 60_000, 500, |_| "705#7F".to_owned());
    let found = traffic.results().findings;
    assert!(found.iter().all(|found| found.rule.id != "lss/left-in-configuration"), "{found:#?}");
}

/// A transfer does not count as unfinished if a reset has ended it, or if frames are missing that may have ended it.
#[test]
fn a_transfer_that_a_gap_or_a_reset_may_have_ended() {
    for reset in [false, true] {
        let mut traffic = Traffic::default();
        let end = if reset { 60_000 } else { 20_000 };
        traffic.every(10, end, 100, |_| "701#05".to_owned()).every(20, end, 100, |_| "704#7F".to_owned());
        traffic.at(19_900, "604#4008100000000000").at(19_901, "584#410810000E000000");
        if reset {
            traffic.at(20_000, "000#8204");
        } else {
            traffic.every(80_010, 100_000, 100, |_| "701#05".to_owned());
            traffic.every(80_020, 100_000, 100, |_| "704#7F".to_owned());
        }
        let next = if reset { 22_000 } else { 85_000 };
        traffic.at(next, "604#4001100000000000").at(next + 1, "584#4F01100000000000");
        let found = traffic.results().findings;
        assert!(found.iter().all(|found| found.rule.id != "sdo/unfinished"), "{reset}: {found:#?}");
    }
}

/// Node 2 is lost for 20 s; node 3 leaves operational every 8 s, before, during and after.
#[test]
fn a_chronic_fault_is_not_the_effect_of_a_loss() {
    let mut traffic = Traffic::default();
    traffic.every(10, 70_000, 100, |_| "701#05".to_owned()).every(20, 70_000, 100, |_| "702#05".to_owned());
    traffic.silence(0x702, 13_000, 33_000);
    for start in (6_000..68_000).step_by(8_000) {
        traffic.every(start + 30, start + 6_000, 100, |_| "703#05".to_owned());
        traffic.every(start + 6_030, start + 7_900, 100, |_| "703#7F".to_owned()).at(start + 7_950, "000#0103");
    }
    let results = traffic.results();
    let heads: Vec<_> = results.stories.iter().map(|story| results.findings[story.head[0]].rule.id).collect();
    assert_eq!(heads, ["nodes/lost", "nodes/state-lost"]);
}

/// Node 2 is lost for ten minutes, in which node 3 leaves operational forty times; node 3 goes on with it for an hour.
#[test]
fn a_chronic_fault_that_begins_in_a_loss_is_not_its_effect() {
    let mut traffic = Traffic::default();
    traffic.every(10, 3_989_000, 1_000, |_| "701#05".to_owned()).every(20, 3_989_000, 1_000, |_| "702#05".to_owned());
    traffic.silence(0x702, 13_000, 613_000);
    for start in (14_000..3_980_000).step_by(15_000) {
        traffic.every(start + 30, start + 9_000, 1_000, |_| "703#05".to_owned());
        traffic.every(start + 9_030, start + 15_000, 1_000, |_| "703#7F".to_owned()).at(start + 14_500, "000#0103");
    }
    let results = traffic.results();
    let heads: Vec<_> = results.stories.iter().map(|story| results.findings[story.head[0]].rule.id).collect();
    let all: Vec<_> = results.findings.iter().map(shown).collect();
    assert_eq!(heads, ["nodes/lost", "nodes/state-lost"], "{all:#?}");
}

/// A request was not answered long before a second device appears.
#[test]
fn what_has_ended_has_no_later_cause() {
    let mut traffic = Traffic::default();
    traffic.every(50, 60_000, 500, |_| "701#05".to_owned()).every(10, 60_000, 1_000, |_| "703#05".to_owned());
    traffic.at(2_450, "603#4000100000000000").at(2_950, "603#8000100000000405");
    traffic.every(32_300, 60_000, 1_000, |_| "703#05".to_owned());
    let results = traffic.results();
    let heads: Vec<_> = results.stories.iter().map(|story| results.findings[story.head[0]].rule.id).collect();
    assert_eq!(heads, ["bus/duplicate-node-id", "sdo/unanswered"]);
}

/// A node that is away from operational for minutes is reported before another node that restarts.
#[test]
fn a_long_absence_is_told_before_a_restart() {
    let mut traffic = Traffic::default();
    traffic.every(10, 300_000, 1_000, |_| "701#05".to_owned()).every(20, 30_000, 1_000, |_| "702#05".to_owned());
    traffic.every(30_020, 300_000, 1_000, |_| "702#7F".to_owned());
    traffic.every(30, 10_000, 1_000, |_| "703#05".to_owned()).at(10_100, "703#00").at(11_000, "000#0103");
    traffic.every(11_100, 300_000, 1_000, |_| "703#05".to_owned());
    let results = traffic.results();
    assert_eq!(head(&results), ("nodes/state-lost", Some(2)));
    let lost = of(&results, "nodes/state-lost")[0];
    assert!(lost.message.ends_with("and not back in the remaining 269.079 s"), "{}", lost.message);
}
