use crate::traffic::{END, machine};
use canvass_analyzer::findings::Severity;

#[test]
fn a_request_without_an_answer() {
    let mut traffic = machine();
    traffic.at(15_100, "603#4000100000000000");
    let finding = traffic.finds("sdo/unanswered", Some(3), 15_100);
    assert!(finding.message.contains("1000h:00"), "{}", finding.message);
}

/// One unanswered request to a silent node is a finding; a scan of many node-IDs is none.
#[test]
fn nodes_that_are_not_there() {
    let mut one = machine();
    one.at(15_100, "609#4000100000000000").finds("sdo/unanswered", Some(9), 15_100);
    let mut scan = machine();
    for node in 7..100_u8 {
        scan.at(15_000 + u64::from(node) * 10, &format!("6{node:02X}#4000100000000000"));
    }
    scan.only(&[]);
}

#[test]
fn a_late_answer() {
    let mut traffic = machine();
    traffic.at(15_100, "604#4000100000000000").at(16_000, "584#4300100091010000");
    let finding = traffic.finds("sdo/late", Some(4), 16_000);
    assert!(finding.message.contains("took 899.9"), "{}", finding.message);
    let mut store = machine();
    store.at(15_100, "604#2310100173617665").at(18_100, "584#6010100100000000").silence(0x704, 15_100, 18_100);
    store.only(&[]);
}

#[test]
fn an_abort() {
    let mut traffic = machine();
    traffic.sdo(15_100, 3, "2304600000000000", "8004600002000106");
    let finding = traffic.finds("sdo/aborted", Some(3), 15_103);
    assert_eq!(finding.severity, Severity::Warning);
    assert!(finding.message.contains("6004h:00 aborted by the server"), "{}", finding.message);
    let mut looking = machine();
    looking.sdo(15_100, 3, "4000500000000000", "8000500000000206");
    assert_eq!(looking.finds("sdo/aborted", Some(3), 15_103).severity, Severity::Info);
}

#[test]
fn broken_rules_of_the_protocol() {
    let rule = "sdo/protocol-violation";
    let mut multiplexer = machine();
    multiplexer.sdo(15_100, 3, "4000100000000000", "4300100196010200").finds(rule, Some(3), 15_103);
    let mut toggle = machine();
    toggle.sdo(15_100, 4, "4008100000000000", "410810000A000000");
    toggle.sdo(15_110, 4, "6000000000000000", "00454E434F444552").sdo(
        15_120,
        4,
        "7000000000000000",
        "0920313700000000",
    );
    toggle.finds(rule, Some(4), 15_123);
    let mut size = machine();
    size.sdo(15_100, 4, "4008100000000000", "410810000B000000");
    size.sdo(15_110, 4, "6000000000000000", "00454E434F444552").sdo(15_120, 4, "7000000000000000", "1920313700000000");
    size.finds(rule, Some(4), 15_123);
    let mut unsolicited = machine();
    unsolicited.at(15_100, "584#4300100096010200").finds(rule, Some(4), 15_100);
    let mut command = machine();
    command.at(15_100, "604#E000100000000000").at(15_101, "584#8000100001000405");
    command.finds_among(&[rule, "sdo/aborted"], rule, Some(4), 15_100);
}

#[test]
fn a_repeated_request() {
    let mut traffic = machine();
    traffic.at(15_100, "604#4000100000000000").sdo(15_400, 4, "4000100000000000", "4300100091010000");
    traffic.finds("sdo/retries", Some(4), 15_400);
}

/// Some interfaces record a sent frame twice, a few microseconds apart.
#[test]
fn a_copy_is_no_repetition() {
    let mut traffic = machine();
    traffic.micros(15_100_000, "604#4000100000000000").micros(15_100_010, "604#4000100000000000");
    traffic.at(15_103, "584#4300100091010000").only(&[]);
}

#[test]
fn storing_in_every_second() {
    let mut traffic = machine();
    for n in 0..12 {
        traffic.sdo(5_100 + n * 1000, 3, "2310100173617665", "6010100100000000");
    }
    traffic.finds("sdo/store-wear", Some(3), 463);
}

/// Two masters send requests on the same channel at the same moment: each takes the answer to the other for its own.
#[test]
fn two_clients_on_one_channel() {
    let mut traffic = machine();
    traffic.at(15_100, "603#4004600000000000").at(15_101, "603#4000100000000000");
    traffic.at(15_103, "583#4304600001000000").at(15_104, "583#4300100096010200");
    let results = traffic.results();
    let message = |rule: &str| {
        let found = results.findings.iter().find(|finding| finding.rule.id == rule).unwrap();
        found.message.clone()
    };
    assert!(message("sdo/unanswered").contains("as if two clients used this channel"), "{}", message("sdo/unanswered"));
    let stale = message("sdo/protocol-violation");
    assert!(stale.contains("6004h:00, asked was 1000h:00"), "{stale}");
    // The value of the wrong answer does not count as 1000h.
    let node = results.buses[0].1.nodes.iter().find(|node| node.0.raw() == 3).unwrap();
    assert_ne!(node.1.identity.device_type, Some(1));
}

/// A device without errors in its history refuses to return the newest one.
#[test]
fn an_empty_error_history() {
    let mut history = machine();
    history.sdo(15_100, 3, "4003100000000000", "4F03100000000000");
    history.sdo(15_110, 3, "4003100100000000", "8003100124000008");
    assert_eq!(history.finds("sdo/aborted", Some(3), 15_113).severity, Severity::Info);
    let mut other = machine();
    other.sdo(15_110, 3, "4001200100000000", "8001200124000008");
    assert_eq!(other.finds("sdo/aborted", Some(3), 15_113).severity, Severity::Warning);
}

/// Each request comes before the previous one has waited for 2 s, and the last one comes just before the end.
#[test]
fn an_absent_node_that_is_asked_again_and_again() {
    let mut traffic = machine();
    traffic.every(14_600, END, 1_900, |_| "609#4000100000000000".to_owned());
    traffic.finds("sdo/unanswered", Some(9), 14_600);
}
