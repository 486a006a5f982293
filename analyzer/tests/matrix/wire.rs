//! The matrix has every message of the wire layer, and its networks send what they say.

use crate::draw::Draw;
use crate::network::{Base, Events, Known, Network};
use crate::play::play;
use crate::sort::Sort;
use canvass_analyzer::network::Network as Decoder;
use std::collections::{BTreeSet, HashMap};

/// All bases with what they can send, each several times.
fn networks() -> impl Iterator<Item = Network> {
    let kinds = Base::ALL.into_iter().flat_map(|(base, _)| Known::ALL.map(|(known, _)| (base, known)));
    let drawn = kinds.flat_map(|(base, known)| (0..4).map(move |seed| (base, known, seed)));
    drawn.map(|(base, known, seed)| Network::new(base, known, Events::Some, Draw::new(seed, "wire")))
}

#[test]
fn every_message_is_sent_by_a_network() {
    let sent: BTreeSet<String> =
        networks().flat_map(|network| network.plan.frames).map(|planned| planned.sort.id()).collect();
    let missing: Vec<String> = Sort::all().iter().map(Sort::id).filter(|id| !sent.contains(id)).collect();
    assert_eq!(missing, ["node/everything"], "the only sort that is no message");
}

/// The decoder reads in each frame the message that its sender meant.
#[test]
fn every_frame_is_of_its_sort() {
    let mut decoded = BTreeSet::new();
    for network in networks() {
        let meant: HashMap<_, _> = network
            .plan
            .frames
            .iter()
            .map(|planned| ((planned.frame.id(), planned.frame.kind()), planned.sort.group))
            .collect();
        let mut decoder = Decoder::new();
        for (node, device) in network.descriptions() {
            decoder.describe(node, device);
        }
        for record in play(&network.plan, &HashMap::new()) {
            let message = decoder.handle(&record).message;
            let group = meant[&(record.frame.id(), record.frame.kind())];
            // Only the second half of an SRDO shows what the first one is, and a PDO has no use while it is configured.
            let Some(sort) = Sort::of_message(&message) else {
                assert!(matches!(group, "srdo" | "pdo"), "{:?}: {message:?}", record.frame);
                continue;
            };
            let service = |group: &str| group.split('-').next().map(str::to_owned);
            assert_eq!(service(sort.group), service(group), "{:?}: {message:?}", record.frame);
            decoded.insert(sort.id());
        }
    }
    // Neither a PDO's trigger nor a guarding request is in the message itself.
    let is_by_others =
        |id: &String| id.starts_with("pdo/") || id == "error-control/guarding" || id == "node/everything";
    let missing: Vec<String> =
        Sort::all().iter().map(Sort::id).filter(|id| !decoded.contains(id) && !is_by_others(id)).collect();
    assert_eq!(missing, [""; 0]);
}
