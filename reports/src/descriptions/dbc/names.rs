//! Names that are C identifiers, as a DBC requires: letters, digits and `_`, at most 32 characters, and each used once.

use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::DeviceDescription;
use std::collections::HashSet;

/// Maximum length of a name that tools accept.
const LONGEST: usize = 32;
/// Maximum length of a node's name, which leaves room in the names of its PDOs.
const LONGEST_NODE: usize = 20;

/// Reserved words of the format.
const RESERVED: &[&str] = &[
    "VERSION",
    "NS_",
    "BS_",
    "BU_",
    "BO_",
    "SG_",
    "EV_",
    "CM_",
    "BA_",
    "VAL_",
    "CAT_",
    "FILTER",
    "BA_DEF_",
    "BA_DEF_DEF_",
    "BO_TX_BU_",
    "SIG_GROUP_",
    "SIG_VALTYPE_",
    "SG_MUL_VAL_",
    "SIGTYPE_VALTYPE_",
    "VAL_TABLE_",
    "ENVVAR_DATA_",
    "DUMMY_NODE_VECTOR0",
    "Vector__XXX",
];

/// Names that are already used.
#[derive(Default)]
pub(super) struct Names(HashSet<String>);

impl Names {
    /// The text as an identifier that is not used yet.
    pub fn free(&mut self, text: &str) -> String {
        let plain = identifier(text);
        let numbered = (2u32..).map(|number| {
            let ending = format!("_{number}");
            let stem: String = plain.chars().take(LONGEST - ending.len()).collect();
            stem + &ending
        });
        // One of the numbers is free, because a PDO has at most 64 signals.
        let free =
            std::iter::once(plain.clone()).chain(numbered).find(|name| !self.0.contains(name)).unwrap_or_default();
        self.0.insert(free.clone());
        free
    }
}

/// The text as an identifier.
pub(super) fn identifier(text: &str) -> String {
    let mut name = String::new();
    for character in text.chars() {
        if character.is_ascii_alphanumeric() {
            name.push(character);
        } else if !name.ends_with('_') {
            name.push('_');
        }
    }
    let name = name.trim_matches('_');
    let begins_well = name.starts_with(|first: char| first.is_ascii_alphabetic());
    let name: String = if begins_well { name.to_owned() } else { format!("_{name}") };
    let name: String = name.chars().take(LONGEST).collect();
    let name = if name.len() == LONGEST { name.trim_end_matches('_').to_owned() } else { name };
    if RESERVED.contains(&name.as_str()) { format!("{name}_") } else { name }
}

/// The name of a node: its configured name, otherwise its product name, with the node-ID: `Sendix_F5868_63`.
pub(super) fn of_node(description: &DeviceDescription, id: NodeId) -> String {
    let configured = description.commissioning.as_ref().map(|it| it.node_name.as_str()).unwrap_or_default();
    let names = [configured, &description.device.product_name, "Node"];
    let name = names.into_iter().find(|name| name.chars().any(|letter| letter.is_ascii_alphanumeric()));
    let name: String = identifier(name.unwrap_or_default()).chars().take(LONGEST_NODE).collect();
    format!("{}_{}", name.trim_end_matches('_'), id.raw())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_identifiers_and_each_once() {
        assert_eq!(identifier("Position value, channel 1"), "Position_value_channel_1");
        assert_eq!(identifier("2nd \u{B5}C temperature [\u{B0}C]"), "_2nd_C_temperature_C");
        assert_eq!(
            (identifier(""), identifier("FILTER"), identifier("BO_")),
            ("_".into(), "FILTER_".into(), "BO".into())
        );
        let long = "a".repeat(40);
        let mut names = Names::default();
        assert_eq!(names.free(&long), "a".repeat(32));
        assert_eq!(names.free(&long), format!("{}_2", "a".repeat(30)));
        assert_eq!((names.free("b c"), names.free("b-c")), ("b_c".to_owned(), "b_c_2".to_owned()));
    }
}
