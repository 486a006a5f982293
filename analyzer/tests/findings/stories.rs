//! Consequences are listed below their cause.

use crate::traffic::{END, Traffic, machine};
use canvass_analyzer::findings::{Results, Story};

fn head(results: &Results, story: &Story) -> (&'static str, Option<u8>) {
    let finding = &results.findings[story.head[0]];
    (finding.rule.id, finding.node.map(|node| node.raw()))
}

fn consequences(results: &Results, story: &Story) -> Vec<(&'static str, Option<u8>)> {
    let of = |at: usize| (results.findings[at].rule.id, results.findings[at].node.map(|node| node.raw()));
    story.consequences.iter().map(|consequence| of(consequence.findings[0])).collect()
}

/// For each consequence, the rule of its cause and its own rule.
fn links(results: &Results, story: &Story) -> Vec<(&'static str, &'static str)> {
    let rule = |at: usize| results.findings[at].rule.id;
    story.consequences.iter().map(|consequence| (rule(consequence.of), rule(consequence.findings[0]))).collect()
}

/// Asserts that each finding is in exactly one story.
fn check(results: &Results) {
    let mut all: Vec<usize> = results.stories.iter().flat_map(Story::all).collect();
    all.sort_unstable();
    assert_eq!(all, (0..results.findings.len()).collect::<Vec<_>>());
}

/// Node 3 consumes the heartbeat of node 1, which loses its supply: node 3 sends an EMCY and leaves operational.
fn supply_lost() -> Traffic {
    let mut traffic = machine();
    traffic.sdo(600, 3, "2316100196000100", "6016100100000000");
    traffic.silence(0x701, 25_000, END).at(25_070, "083#3081110000000000");
    traffic.silence(0x703, 25_080, END).every(25_160, END, 100, |_| "703#7F".to_owned());
    traffic.silence(0x183, 25_080, END).silence(0x283, 25_080, END);
    traffic
}

#[test]
fn a_node_that_others_wait_for() {
    let results = supply_lost().results();
    check(&results);
    assert_eq!(head(&results, &results.stories[0]), ("nodes/lost", Some(1)));
    let follows = consequences(&results, &results.stories[0]);
    let rules: Vec<&str> = follows.iter().map(|row| row.0).collect();
    assert!(rules.starts_with(&["nodes/consumer-time", "emcy/raised"]), "{rules:?}");
    assert!(rules.contains(&"emcy/never-cleared") && rules.contains(&"nodes/state-lost"), "{rules:?}");
    assert!(follows.iter().all(|row| row.1 == Some(3)));
    assert_eq!(results.stories.len(), 1);
    // Each finding of the chain follows from the one before.
    let links = links(&results, &results.stories[0]);
    let chain = ["nodes/lost", "nodes/consumer-time", "emcy/raised", "nodes/state-lost"];
    for pair in chain.windows(2) {
        assert!(links.contains(&(pair[0], pair[1])), "{pair:?} in {links:?}");
    }
    // The finding begins at the end of the consumer time, which is after its cause.
    let first = |rule: &str| results.findings.iter().find(|finding| finding.rule.id == rule).map(|found| found.first);
    assert!(first("nodes/lost") < first("nodes/consumer-time"));
}

/// The findings of one node keep their cause at another one; what concerns neither is left out.
#[test]
fn the_findings_of_a_node_keep_their_cause() {
    let mut traffic = supply_lost();
    // Another node reports an error of its own.
    traffic.at(5_000, "082#1042090000000000").at(6_000, "082#0000000000000000");
    let all = traffic.results();
    let of = |node: u8| {
        let mut results = traffic.results();
        results.keep_nodes(|other| other.raw() == node);
        check(&results);
        results
    };
    let third = of(3);
    assert_eq!(third.stories.len(), 1);
    assert_eq!(head(&third, &third.stories[0]), ("nodes/lost", Some(1)));
    assert_eq!(
        consequences(&third, &third.stories[0]),
        all.stories
            .iter()
            .find(|story| head(&all, story) == ("nodes/lost", Some(1)))
            .map(|story| consequences(&all, story))
            .unwrap()
    );
    assert_eq!(third.left_out, all.findings.len() - third.findings.len());
    assert_eq!(third.buses[0].1.nodes.len(), all.buses[0].1.nodes.len(), "the statistics cover all nodes");
    let second = of(2);
    assert!(second.findings.iter().all(|finding| finding.node.map(|node| node.raw()) == Some(2)));
    assert!(!second.findings.is_empty() && second.findings.len() + third.findings.len() <= all.findings.len());
    assert!(of(99).findings.is_empty());
}

/// Sixty objects that a device lacks are one story, which lists the objects.
#[test]
fn aborts_of_the_same_kind_are_one() {
    let mut traffic = Traffic::default();
    for n in 0..60_u64 {
        let object = format!("{:02X}20{:02X}", n, n % 3);
        traffic.sdo(1_000 + n * 20, 5, &format!("23{object}00000000"), &format!("80{object}02000106"));
    }
    let results = traffic.results();
    check(&results);
    assert_eq!((results.findings.len(), results.stories.len()), (60, 1));
    assert!(results.findings.iter().all(|finding| finding.object.is_some()));
}

/// Two nodes that restart together have one cause; a node that restarts later has its own.
#[test]
fn what_happens_to_several_nodes_at_once_is_one() {
    let mut traffic = Traffic::default();
    for node in [3, 4, 5] {
        let at = if node == 5 { 15_000 } else { 8_000 + 10 * node };
        traffic.every(100 + node, at, 500, |_| format!("70{node}#05")).at(at + 40, &format!("70{node}#00"));
        traffic.every(at + 500, 20_000, 500, |_| format!("70{node}#7F"));
    }
    let results = traffic.results();
    check(&results);
    let nodes: Vec<usize> = results.stories.iter().map(|story| story.head.len()).collect();
    assert_eq!(nodes, [2, 1], "{:#?}", results.stories);
}

/// A loss is reported before an EMCY, and an EMCY before aborts, whichever came first.
#[test]
fn the_worst_is_told_first() {
    let mut traffic = machine();
    traffic.sdo(5_000, 3, "2304600000000000", "8004600002000106").at(8_000, "083#1050110000000000");
    traffic.at(8_500, "083#0000000000000000").silence(0x701, 20_000, 24_000);
    let results = traffic.results();
    check(&results);
    let heads: Vec<&str> = results.stories.iter().map(|story| head(&results, story).0).collect();
    assert_eq!(heads, ["nodes/lost", "emcy/raised", "sdo/aborted"]);
}
