//! The reviewed list of cells whose incident can't be known from the capture.

use serde::Deserialize;

/// Cells that are not to be named, with the reasons.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Open {
    open: Vec<Group>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Group {
    cells: Vec<String>,
    reason: String,
}

impl Open {
    /// Reads the list.
    pub fn read() -> Self {
        toml::from_str(include_str!("open.toml")).expect("the list of cells that can't be known is readable")
    }

    /// The reason why a cell can't be known; `None` if it can.
    pub fn reason(&self, cell: &str) -> Option<&str> {
        let group = self.open.iter().find(|group| group.cells.iter().any(|pattern| matches(pattern, cell)))?;
        Some(&group.reason)
    }

    /// All patterns with their reasons.
    pub fn patterns(&self) -> impl Iterator<Item = (&str, &str)> {
        self.open.iter().flat_map(|group| group.cells.iter().map(|cell| (cell.as_str(), group.reason.as_str())))
    }
}

/// Whether a text has the form of a pattern, in which `*` stands for any characters.
pub fn matches(pattern: &str, text: &str) -> bool {
    let Some((head, rest)) = pattern.split_once('*') else { return pattern == text };
    let Some(text) = text.strip_prefix(head) else { return false };
    (0..=text.len()).filter(|at| text.is_char_boundary(*at)).any(|at| matches(rest, &text[at..]))
}
