//! The nodes that must obey an NMT command, and the nodes that come back after a reset.

use crate::traffic::Traffic;
use canvass_analyzer::findings::Severity;

/// The commands of the master (node 127) to all nodes, which node 5 obeys: stop, go to pre-operational, reset.
fn commands_to_all() -> Traffic {
    let mut traffic = Traffic::default();
    traffic.at(0, "77F#00").every(1_000, 30_000, 1_000, |_| "77F#05".to_owned());
    traffic.at(100, "705#00").every(600, 3_000, 500, |_| "705#7F".to_owned());
    traffic.at(3_001, "000#0100").every(3_100, 10_000, 500, |_| "705#05".to_owned());
    traffic.at(10_001, "000#0200").every(10_100, 15_000, 500, |_| "705#04".to_owned());
    traffic.at(15_001, "000#8000").every(15_100, 20_000, 500, |_| "705#7F".to_owned());
    traffic.at(20_001, "000#8200").at(20_300, "705#00").every(20_800, 30_000, 500, |_| "705#7F".to_owned());
    traffic
}

#[test]
fn the_master_does_not_hear_its_own_commands() {
    commands_to_all().only(&[]);
}

/// Two nodes do not hear what node 5 obeys: at most one of them is the master.
#[test]
fn of_two_nodes_that_do_not_obey_one_is_no_master() {
    let mut traffic = commands_to_all();
    traffic.every(1_030, 30_000, 1_000, |_| "70A#05".to_owned());
    let found = traffic.only(&["nodes/command-not-obeyed"]);
    let nodes: Vec<_> = found.iter().map(|finding| finding.node.map(|node| node.raw())).collect();
    assert_eq!(nodes, [Some(10), Some(127)], "{found:?}");
    for finding in found {
        assert_eq!((finding.severity, finding.count), (Severity::Info, 3));
        assert!(finding.message.contains("correct if this is the NMT master itself"), "{}", finding.message);
    }
}

/// Node 5 stays operational when all nodes are told to stop.
fn ignored_stop(before: impl Fn(&mut Traffic)) -> Severity {
    let mut traffic = Traffic::default();
    traffic.at(100, "705#00").at(500, "000#0100").every(600, 20_000, 500, |_| "705#05".to_owned());
    before(&mut traffic);
    traffic.at(10_001, "000#0200").finds("nodes/command-not-obeyed", Some(5), 10_001).severity
}

#[test]
fn a_slave_that_ignores_a_command_to_all() {
    assert_eq!(ignored_stop(|_| {}), Severity::Info, "it may be the master");
    let named = |traffic: &mut Traffic| _ = traffic.at(550, "000#0105");
    assert_eq!(ignored_stop(named), Severity::Error);
    let asked = |traffic: &mut Traffic| _ = traffic.sdo(700, 5, "4000100000000000", "4300100091010000");
    assert_eq!(ignored_stop(asked), Severity::Error);
    let sending = |traffic: &mut Traffic| _ = traffic.at(700, "185#0102");
    assert_eq!(ignored_stop(sending), Severity::Error);
    let obedient = |traffic: &mut Traffic| {
        traffic.silence(0x705, 5_000, 7_000).at(5_001, "000#0200").at(5_100, "705#04").at(5_600, "705#04");
        traffic.at(6_000, "000#0100").at(6_100, "705#05").at(6_600, "705#05");
    };
    assert_eq!(ignored_stop(obedient), Severity::Error);
}

/// LSS gives node 5 the node-ID 50. The node comes back with it, or does not come back.
#[test]
fn a_node_that_comes_back_with_another_node_id() {
    let reset = || {
        let mut traffic = Traffic::default();
        traffic.at(0, "705#00").every(500, 3_000, 500, |_| "705#7F".to_owned());
        traffic.at(10, "709#00").every(300, 15_000, 500, |_| "709#7F".to_owned());
        traffic.at(3_200, "000#8205");
        traffic
    };
    let mut moved = reset();
    moved.at(3_000, "7E5#0401000000000000");
    moved.at(3_010, "7E5#1132000000000000").at(3_020, "7E4#1100000000000000");
    moved.at(3_030, "7E5#1700000000000000").at(3_040, "7E4#1700000000000000").at(3_050, "7E5#0400000000000000");
    moved.at(3_500, "732#00").every(4_000, 15_000, 500, |_| "732#7F".to_owned());
    moved.only(&[]);
    reset().finds("nodes/no-boot-up", Some(5), 3_200);
}
