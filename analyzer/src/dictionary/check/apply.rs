//! Fixes a file: applies all fixes, and checks again until nothing is left to fix.

use super::{Finding, check};
use crate::dictionary::rules::{Rule, text as rules};
use crate::dictionary::source::{DescriptionError, Encoding};

/// Limit of the passes. One pass applies fixes that do not overlap; a list with many missing objects takes one pass for
/// each object.
const MOST_PASSES: usize = 1000;

/// A fixed file.
#[derive(Debug)]
pub struct FixedFile {
    /// The new bytes.
    pub bytes: Vec<u8>,
    /// The rule of each fix, in the order of the fixes.
    pub rules: Vec<&'static Rule>,
}

/// Applies all fixes that need no guessing, for findings that are `wanted`.
///
/// # Errors
/// See [`check`].
pub fn apply_fixes(bytes: &[u8], wanted: impl Fn(&Finding) -> bool) -> Result<FixedFile, DescriptionError> {
    let mut fixed = FixedFile { bytes: bytes.to_vec(), rules: Vec::new() };
    for _ in 0..MOST_PASSES {
        let Some(next) = pass(&fixed.bytes, &wanted)? else { break };
        fixed.bytes = next.bytes;
        fixed.rules.extend(next.rules);
    }
    Ok(fixed)
}

/// The file after one pass; `None` if there was nothing to fix.
fn pass(bytes: &[u8], wanted: impl Fn(&Finding) -> bool) -> Result<Option<FixedFile>, DescriptionError> {
    let checked = check(bytes, None)?;
    let mut encoding = checked.source.encoding;
    let old = &checked.source.text;
    let mut edits = Vec::new();
    let mut rules = Vec::new();
    for finding in checked.open().filter(|finding| wanted(finding)) {
        let Some(fix) = &finding.fix else { continue };
        let overlaps = |edit: &super::Edit| {
            edits
                .iter()
                .any(|other: &super::Edit| edit.range.start <= other.range.end && other.range.start <= edit.range.end)
        };
        // An edit whose range cuts a character would damage the text.
        if fix.edits.iter().any(overlaps) || !fix.edits.iter().all(|edit| old.get(edit.range.clone()).is_some()) {
            continue;
        }
        if matches!(finding.problem.rule, rule if rule == &rules::BYTE_ORDER_MARK || rule == &rules::UTF_16) {
            encoding = Encoding::Utf8;
        }
        edits.extend(fix.edits.iter().cloned());
        rules.push(finding.problem.rule);
    }
    if rules.is_empty() {
        return Ok(None);
    }
    edits.sort_by_key(|edit| edit.range.start);
    let mut text = String::with_capacity(old.len() + 256);
    let mut at = 0;
    for edit in &edits {
        text.push_str(old.get(at..edit.range.start).unwrap_or_default());
        text.push_str(&edit.text);
        at = edit.range.end;
    }
    text.push_str(old.get(at..).unwrap_or_default());
    Ok(encoding.encode(&text).filter(|next| next != bytes).map(|bytes| FixedFile { bytes, rules }))
}
