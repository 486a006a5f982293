//! A network that does not come up: at which step the boot of a node stands still, and for whom nothing was done.

use crate::traffic::Traffic;

/// The master (node 9) resets all, and three nodes boot. It reads device type and two numbers of the identity of node 22.
fn begun() -> Traffic {
    let mut traffic = Traffic::default();
    traffic.at(0, "709#00").at(1, "000#8200");
    for node in [24, 23, 22] {
        traffic.at(30, &format!("7{node:02X}#00"));
    }
    traffic.sdo(40, 22, "4000100000000000", "4300100092010200");
    traffic.sdo(50, 22, "4018100100000000", "431810015B020000");
    traffic.sdo(60, 22, "4018100200000000", "4318100217290000");
    traffic
}

fn sync(traffic: &mut Traffic) -> &mut Traffic {
    traffic.every(70, 5_000, 10, |_| "080#".to_owned())
}

#[test]
fn a_boot_that_stands_still() {
    let mut traffic = begun();
    let found = sync(&mut traffic).finds("nodes/boot-unfinished", Some(22), 63);
    assert!(
        found.message.starts_with(
            "after its boot-up, its device type (1000h) was read, its identity was read (1018h:01, 02); it was neither \
             configured nor started in the 4.9"
        ),
        "{}",
        found.message
    );
    assert!(found.message.ends_with("while SYNC goes on; nothing was done for: nodes 23, 24"), "{}", found.message);
    assert_eq!(found.evidence.len(), 2);
}

#[test]
fn a_boot_that_stands_still_before_the_start() {
    let mut traffic = begun();
    traffic.sdo(70, 22, "2B17100064000000", "6017100000000000");
    traffic.every(100, 5_000, 100, |_| "716#7F".to_owned());
    traffic.sdo(80, 23, "4000100000000000", "4300100092010200");
    let found = sync(&mut traffic).finds("nodes/boot-unfinished", Some(23), 83);
    assert!(found.message.contains("not started either: node 22; nothing was done for: node 24"), "{}", found.message);
}

/// A refused access stops the boot: the refusal comes first.
#[test]
fn a_refusal_that_stops_the_boot() {
    let mut traffic = begun();
    traffic.sdo(70, 22, "4018100300000000", "8018100311000906");
    let results = sync(&mut traffic).results();
    let story: Vec<_> = results.stories[0].all().map(|at| results.findings[at].rule.id).collect();
    assert_eq!(story, ["sdo/aborted", "nodes/boot-unfinished"], "{:#?}", results.findings);
    let boot = results.findings.iter().find(|found| found.rule.id == "nodes/boot-unfinished").unwrap();
    assert!(boot.message.contains("the access to 1018h:03 was refused; it was neither"), "{}", boot.message);
}

/// A master that starts all its nodes in the end, or each; nodes that start themselves; a capture that ends during the
/// boot; and a tool that only looks.
#[test]
fn networks_that_come_up() {
    let mut all = begun();
    all.at(200, "000#0100");
    sync(&mut all).only(&[]);
    let mut each = begun();
    for node in [22, 23, 24] {
        each.at(180 + node, &format!("000#01{node:02X}"));
    }
    sync(&mut each).only(&[]);
    let mut own = begun();
    for node in [22, 23, 24] {
        own.every(100 + node, 5_000, 500, |_| format!("7{node:02X}#05"));
    }
    sync(&mut own).only(&[]);
    let mut ends = begun();
    ends.every(70, 160, 10, |_| "080#".to_owned()).only(&[]);
    let mut tool = begun();
    tool.every(100, 5_000, 500, |_| "716#7F".to_owned()).only(&[]);
}
