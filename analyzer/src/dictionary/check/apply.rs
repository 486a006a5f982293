//! Fixes a file: applies what fixes its findings, and looks again until nothing is left that can be fixed.

use super::{Finding, check};
use crate::dictionary::eds::DescriptionError;
use crate::dictionary::rules::{Rule, text as rules};

/// Each pass fixes what does not overlap; a list that misses many objects takes a pass for each.
const MOST_PASSES: usize = 1000;

/// A file that was fixed.
#[derive(Debug)]
pub struct FixedFile {
    /// The new bytes.
    pub bytes: Vec<u8>,
    /// The rules whose breaches were fixed, one for each, in the order in which they were.
    pub rules: Vec<&'static Rule>,
}

/// Fixes what can be fixed without guessing, of the findings that are `wanted`.
///
/// # Errors
/// As [`check`].
pub fn apply_fixes(bytes: &[u8], wanted: impl Fn(&Finding) -> bool) -> Result<FixedFile, DescriptionError> {
    let mut fixed = FixedFile { bytes: bytes.to_vec(), rules: Vec::new() };
    for _ in 0..MOST_PASSES {
        let Some(next) = pass(&fixed.bytes, &wanted)? else { break };
        fixed.bytes = next.bytes;
        fixed.rules.extend(next.rules);
    }
    Ok(fixed)
}

/// The file after one pass; `None` if there is nothing to do.
fn pass(bytes: &[u8], wanted: impl Fn(&Finding) -> bool) -> Result<Option<FixedFile>, DescriptionError> {
    let checked = check(bytes, None)?;
    let mut encoding = Encoding::of(bytes);
    let mut edits = Vec::new();
    let mut rules = Vec::new();
    for finding in checked.open().filter(|finding| wanted(finding)) {
        let Some(fix) = &finding.fix else { continue };
        let overlaps = |edit: &super::Edit| {
            edits
                .iter()
                .any(|other: &super::Edit| edit.range.start <= other.range.end && other.range.start <= edit.range.end)
        };
        if fix.edits.iter().any(overlaps) {
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
    let mut text = String::with_capacity(checked.text.len() + 256);
    let mut at = 0;
    for edit in &edits {
        text.push_str(checked.text.get(at..edit.range.start).unwrap_or_default());
        text.push_str(&edit.text);
        at = edit.range.end;
    }
    text.push_str(checked.text.get(at..).unwrap_or_default());
    Ok(encoding.encode(&text).filter(|next| next != bytes).map(|bytes| FixedFile { bytes, rules }))
}

/// How the characters of a file are written.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Encoding {
    Utf8,
    Utf8WithMark,
    Utf16LowFirst,
    Utf16HighFirst,
    Latin1,
}

impl Encoding {
    /// As the reader tells them apart.
    pub fn of(bytes: &[u8]) -> Self {
        match bytes {
            [0xFF, 0xFE, ..] => Self::Utf16LowFirst,
            [0xFE, 0xFF, ..] => Self::Utf16HighFirst,
            [0xEF, 0xBB, 0xBF, ..] => Self::Utf8WithMark,
            _ if std::str::from_utf8(bytes).is_ok() => Self::Utf8,
            _ => Self::Latin1,
        }
    }

    /// Whether a text that was read of these bytes would be written as them.
    pub fn keeps(self, text: &str, bytes: &[u8]) -> bool {
        match self {
            Self::Utf8 => text.as_bytes() == bytes,
            other => other.encode(text).is_some_and(|written| written == bytes),
        }
    }

    /// The bytes of a text; `None` if it has characters that are not in Latin-1.
    pub fn encode(self, text: &str) -> Option<Vec<u8>> {
        let units = |mark: [u8; 2], bytes: fn(u16) -> [u8; 2]| {
            mark.into_iter().chain(text.encode_utf16().flat_map(bytes)).collect::<Vec<u8>>()
        };
        Some(match self {
            Self::Utf8 => text.as_bytes().to_vec(),
            Self::Utf8WithMark => [b"\xEF\xBB\xBF", text.as_bytes()].concat(),
            Self::Utf16LowFirst => units([0xFF, 0xFE], u16::to_le_bytes),
            Self::Utf16HighFirst => units([0xFE, 0xFF], u16::to_be_bytes),
            Self::Latin1 => text.chars().map(|character| u8::try_from(character).ok()).collect::<Option<_>>()?,
        })
    }
}
