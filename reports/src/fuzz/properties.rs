//! A property in full.

use canvass_fuzzer::Property;

/// What `canvass explain PROP-05` prints.
pub fn explain(property: Property) -> String {
    let text: Vec<&str> = property.explanation().lines().map(str::trim).collect();
    format!(
        "{property}: {}\n\n{}\n\nchecked by `canvass fuzz BUS`; see docs/fuzzing.md\n",
        property.title(),
        text.join("\n").trim()
    )
}
