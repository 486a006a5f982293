//! All rules.

use super::rule::Definition;
use std::sync::LazyLock;

/// The families in the order of listings; families of device profiles follow.
const FAMILIES: [&str; 8] = ["capture", "bus", "nodes", "sdo", "pdo", "emcy", "lss", "srdo"];

/// All rules, sorted by family, then by id.
static RULES: LazyLock<Vec<&'static Definition>> = LazyLock::new(|| {
    let mut rules: Vec<&'static Definition> = inventory::iter::<Definition>.into_iter().collect();
    let family = |id: &str| FAMILIES.iter().position(|family| id.split('/').next() == Some(family));
    rules.sort_by_key(|rule| (family(rule.metadata.id).unwrap_or(FAMILIES.len()), rule.metadata.id));
    rules
});

/// Whether a rule belongs to a device profile: its findings concern the device's function, not the bus.
pub(super) fn is_of_profile(id: &str) -> bool {
    !FAMILIES.iter().any(|family| id.split('/').next() == Some(family))
}

/// All rules.
pub fn all() -> impl Iterator<Item = &'static Definition> {
    RULES.iter().copied()
}

/// The rule with this id.
pub fn find(id: &str) -> Option<&'static Definition> {
    all().find(|definition| definition.metadata.id == id)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::{Make, Thresholds};
    use std::collections::BTreeSet;

    #[test]
    fn every_rule_says_what_why_and_what_to_do() {
        let mut ids = BTreeSet::new();
        for metadata in all().map(|definition| definition.metadata) {
            assert!(ids.insert(metadata.id), "{} twice", metadata.id);
            let texts = [metadata.title, metadata.what, metadata.why, metadata.advice];
            assert!(texts.iter().all(|text| text.len() > 15 && !text.ends_with(' ')), "{}", metadata.id);
            assert!(texts[1..].iter().all(|text| text.ends_with('.')), "{}", metadata.id);
            assert!(!metadata.title.ends_with('.'), "{}", metadata.id);
        }
        assert!(ids.len() < 256, "a rule's place must fit into a byte");
    }

    #[test]
    fn effects_name_rules_or_families() {
        for metadata in all().map(|definition| definition.metadata) {
            for name in metadata.leads_to.iter().flat_map(|effect| effect.rules) {
                let is_family = name.strip_suffix('/').is_some_and(|family| FAMILIES.contains(&family));
                assert!(is_family || find(name).is_some(), "{} leads to {name}", metadata.id);
            }
            for (cause, effect) in metadata.follows {
                assert!(find(cause).is_some() && effect.names(metadata.id), "{} follows {cause}", metadata.id);
            }
        }
    }

    #[test]
    fn a_loss_comes_before_a_restart_and_that_before_an_emcy() {
        let ids = ["nodes/lost", "nodes/boot-up-without-command", "emcy/raised", "nodes/state-lost", "sdo/aborted"];
        assert!(ids.map(|id| find(id).unwrap().metadata.rank).is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn every_rule_can_be_made_and_belongs_to_a_family() {
        for rule in all() {
            match rule.make {
                Make::Bus(make) => drop(make(&Thresholds::default())),
                Make::Capture(make) => drop(make(&Thresholds::default())),
                Make::Nothing => {}
            }
            let of_profile = ["encoder/", "drive/"].iter().any(|family| rule.metadata.id.starts_with(family));
            assert_eq!(is_of_profile(rule.metadata.id), of_profile, "{}", rule.metadata.id);
        }
    }
}
