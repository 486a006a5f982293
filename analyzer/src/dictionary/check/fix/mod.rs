//! What fixes a breach without guessing: the rule's own edit of the text. Comments and order stay.

mod lines;
mod lists;
mod values;

use super::Finding;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::rules;
use crate::dictionary::source::Source;
use std::ops::Range;

/// What fixes a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// What it does: `write 01:30PM`.
    pub title: String,
    /// The changes of the text. None for what is changed by writing the file in another character set.
    pub edits: Vec<Edit>,
}

/// One change of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// What is replaced, in bytes of the text; empty for an insertion.
    pub range: Range<usize>,
    /// What stands there instead.
    pub text: String,
}

impl Fix {
    fn replace(range: Range<usize>, text: impl Into<String>) -> Self {
        let text = text.into();
        Self { title: format!("write {text}"), edits: vec![Edit { range, text }] }
    }

    fn edits(title: impl Into<String>, edits: Vec<Edit>) -> Self {
        Self { title: title.into(), edits }
    }
}

/// What fixes that finding, where it can be fixed without guessing.
pub(super) fn of(finding: &Finding, source: &Source<'_>, description: &DeviceDescription) -> Option<Fix> {
    let rule = finding.problem.rule;
    let is = |other: &rules::Rule| rule == other;
    if source.is_xml() {
        return values::of_xml(finding, source);
    }
    if is(&rules::text::BYTE_ORDER_MARK) || is(&rules::text::UTF_16) {
        return Some(Fix::edits("store the file as UTF-8 without byte order mark", Vec::new()));
    }
    lines::of(finding, source)
        .or_else(|| lists::of(finding, source, description))
        .or_else(|| values::of(finding, source))
}
