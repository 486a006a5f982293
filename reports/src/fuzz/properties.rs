//! The full text of a property.

use canvass_fuzzer::Property;

/// The text of `canvass explain PROP-05`.
pub fn explain(property: Property) -> String {
    let text: Vec<&str> = property.explanation().lines().map(str::trim).collect();
    format!(
        "{property}: {}\n\n{}\n\nchecked by `canvass fuzz BUS`; see docs/fuzzing.md\n",
        property.title(),
        text.join("\n").trim()
    )
}
