//! A node is recognised as the built-in model that it is, and as no other model.

#![cfg(test)]

use canvass_analyzer::network::{Candidate, Fact};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_device::models::Model;

/// Models to whose devices the manuals give the same device type, name and identity. If the PDOs of both models are
/// alike, a node with these values is recognised as the first model, with the second as an alternative; otherwise as
/// neither of them.
const SAME: &[(&str, &str)] = &[("kuebler-sendix-58x8", "kuebler-sendix-f58"), ("kuebler-c100", "kuebler-d125")];

/// Whether a node could be of both models: the models have no object whose known values differ.
fn can_be_both(a: &Candidate, b: &Candidate) -> bool {
    let contradicts = |(object, fact): &(Multiplexer, Fact)| {
        let other = b.facts.iter().find(|other| other.0 == *object).map(|other| &other.1);
        other.is_some_and(|other| !overlap(fact, other))
    };
    !a.facts.iter().any(contradicts)
}

fn overlap(a: &Fact, b: &Fact) -> bool {
    match (a, b) {
        (Fact::Number(a), Fact::Number(b)) => a.iter().any(|number| b.contains(number)),
        (Fact::Text(a), Fact::Text(b)) => a == b,
        (Fact::Text(text), Fact::Begins(head)) | (Fact::Begins(head), Fact::Text(text)) => text.starts_with(head),
        (Fact::Begins(a), Fact::Begins(b)) => a.starts_with(b) || b.starts_with(a),
        _ => false,
    }
}

#[test]
fn models_can_be_told_apart_but_for_those_that_are_known_to_be_the_same() {
    for (n, a) in Model::all().iter().enumerate() {
        for b in &Model::all()[n + 1..] {
            let is_known =
                SAME.iter().any(|&(one, other)| [(a.id(), b.id()), (b.id(), a.id())].contains(&(one, other)));
            assert_eq!(can_be_both(&a.candidate(), &b.candidate()), is_known, "{} and {}", a.id(), b.id());
        }
    }
}

/// Each model is recognised by the facts of its own description.
#[test]
fn every_model_has_facts_enough_and_its_own_defaults_fit_them() {
    for model in Model::all() {
        let candidate = model.candidate();
        for (object, fact) in &candidate.facts {
            let value =
                model.description().dictionary.entry(*object).ok().and_then(|entry| entry.start_value(NodeId::MIN));
            let Some(bytes) = value.and_then(|value| {
                let data_type = model.description().dictionary.entry(*object).ok()?.data_type;
                value.encode(data_type).ok()
            }) else {
                continue;
            };
            assert!(fact.holds(&bytes), "{} {object}: {fact:?}, {bytes:02X?}", model.id());
        }
        let has = |index, sub| candidate.facts.iter().any(|fact| fact.0 == Multiplexer::new(index, sub));
        assert!(has(0x1018, 1) && has(0x1018, 2) || has(0x1000, 0) && has(0x1008, 0), "{}", model.id());
    }
}
