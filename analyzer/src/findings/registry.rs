//! All rules.

use super::rule::Definition;
use super::{bus, capture, emcy, encoder, lss, nodes, pdo, sdo};

/// The rules by family: the order in which they are listed.
static FAMILIES: [&[Definition]; 8] =
    [capture::RULES, bus::RULES, nodes::RULES, sdo::RULES, pdo::RULES, emcy::RULES, lss::RULES, encoder::RULES];

/// All rules.
pub fn all() -> impl Iterator<Item = &'static Definition> {
    FAMILIES.iter().flat_map(|family| family.iter())
}

/// The rule with that id.
pub fn find(id: &str) -> Option<&'static Definition> {
    all().find(|definition| definition.metadata.id == id)
}

#[cfg(test)]
mod tests {
    use super::*;
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

    /// A rule that asks for a threshold it does not have would compare with 0.
    #[test]
    fn every_rule_can_be_made() {
        for make in all().filter_map(|definition| definition.make) {
            make(&Default::default());
        }
    }
}
