//! Fixes of findings, for the rules where a fix needs no guessing. Comments and the order of the lines stay.

mod lines;
mod lists;
mod values;

use super::Finding;
use crate::dictionary::description::DeviceDescription;
use crate::dictionary::rules;
use crate::dictionary::source::Source;
use std::ops::Range;

/// The fix of a finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fix {
    /// The effect of the fix, such as `write 01:30PM`.
    pub title: String,
    /// The changes of the text; empty if the fix only changes the character set.
    pub edits: Vec<Edit>,
}

/// One change of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// The replaced bytes of the text; empty for an insertion.
    pub range: Range<usize>,
    /// The new text.
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

/// The fix of a finding; `None` if it needs guessing.
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
