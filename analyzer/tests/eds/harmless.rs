//! Properties of every description, whatever the file.

use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::{DeviceDescription, consistency};
use proptest::prelude::*;

/// No text of a problem acts on a terminal, and every start value fits its type.
pub fn check(description: &DeviceDescription) -> Result<(), TestCaseError> {
    for problem in description.problems.iter().chain(&consistency::check(description)) {
        prop_assert!(!problem.to_string().chars().any(char::is_control), "{problem}");
    }
    for (_, entry) in description.dictionary.entries() {
        if let Some(value) = entry.start_value(NodeId::MAX) {
            prop_assert!(value.encode(entry.data_type).is_ok(), "{value} in {}", entry.data_type);
        }
    }
    Ok(())
}
