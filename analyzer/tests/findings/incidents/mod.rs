//! Networks of 3 to 20 nodes, healthy ones and ones with one fault each. The first story must name the fault from which
//! the other findings follow.
//!
//! Here the other nodes and the master react: they report the missing heartbeat, leave operational, and reset the
//! node. The matrix (`tests/matrix`) has more that goes wrong, and nobody who reacts to it. `CANVASS_INCIDENTS` sets the
//! number of networks, and `--nocapture` shows the table.

mod network;
mod random;
mod roots;

use crate::traffic::shown;
use canvass_analyzer::findings::{Results, Severity};
use network::Network;
use random::Random;
use roots::Root;
use std::io::Write;

/// Number of networks of each kind; the environment variable overrides the default.
fn runs() -> u64 {
    std::env::var("CANVASS_INCIDENTS").ok().and_then(|number| number.parse().ok()).unwrap_or(60)
}

/// Prints a line of the table.
fn say(line: &str) {
    // A closed output changes nothing that the test checks.
    let _ = writeln!(std::io::stdout(), "{line}");
}

/// The rule and the nodes of the findings at the head of the first story.
fn named(results: &Results) -> Option<(&'static str, Vec<Option<u8>>)> {
    let head = &results.stories.first()?.head;
    let nodes = head.iter().map(|at| results.findings[*at].node.map(|node| node.raw())).collect();
    Some((results.findings[*head.first()?].rule.id, nodes))
}

#[test]
fn the_first_story_names_what_broke_first() {
    let mut right = [0_u64; Root::ALL.len()];
    let mut all = [0_u64; Root::ALL.len()];
    let mut wrong = Vec::new();
    for seed in 0..runs() {
        let mut random = Random::new(seed);
        let mut network = Network::new(&mut random);
        let place = seed as usize % Root::ALL.len();
        let root = Root::ALL[place];
        let expected = root.break_it(&mut network, &mut random);
        let results = network.traffic().results();
        let found = named(&results);
        all[place] += 1;
        let is_right = found.as_ref().is_some_and(|(rule, nodes)| {
            expected.rules.contains(rule) && (expected.node.is_none() || nodes.contains(&expected.node))
        });
        if is_right {
            right[place] += 1;
        } else {
            let others: Vec<_> = results.findings.iter().map(shown).collect();
            wrong.push(format!("seed {seed}, {root:?} of {:?}: named {found:?} among {others:#?}", expected.node));
        }
    }
    say("| what breaks | named first |\n|---|---:|");
    for (place, root) in Root::ALL.iter().enumerate() {
        say(&format!("| {} | {} of {} |", root.words(), right[place], all[place]));
    }
    let (right, all): (u64, u64) = (right.iter().sum(), all.iter().sum());
    say(&format!("| all | {right} of {all} |"));
    say(&wrong.join("\n"));
    assert!(right * 100 >= all * 95, "{right} of {all}");
}

#[test]
fn nothing_is_named_in_healthy_networks() {
    for seed in 0..runs() {
        let mut random = Random::new(seed ^ 0x5EED_0000);
        let mut network = Network::new(&mut random);
        roots::operate(&mut network, &mut random);
        let results = network.traffic().results();
        let faults = results.findings.iter().filter(|finding| finding.severity > Severity::Info);
        let faults: Vec<_> = faults.map(shown).collect();
        assert!(faults.is_empty(), "seed {seed}: {faults:#?}");
    }
    say(&format!("healthy networks: nothing named in {} of {}", runs(), runs()));
}
