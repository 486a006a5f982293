//! Fixes of values in another form: dates, times, flags, numbers, access types.

use super::{Fix, Source};
use crate::dictionary::check::Finding;
use crate::dictionary::eds::{access_of_habit, number};
use crate::dictionary::moment;
use crate::dictionary::rules;

/// The fix in an EDS, where the finding is at the value.
pub(super) fn of(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let rule = finding.problem.rule;
    let text = source.text.get(finding.span.clone())?;
    let is = |other: &rules::Rule| rule == other;
    let fixed = if is(&rules::file::DATE) {
        moment::eds_date(text)?
    } else if is(&rules::file::TIME) {
        moment::eds_time(text)?
    } else if is(&rules::field::FLAG) {
        flag(text)?.to_owned()
    } else if is(&rules::number::FORM) || is(&rules::number::NODE_ID_BEHIND) {
        flag(text).map(str::to_owned).or_else(|| number::in_form(text))?
    } else if is(&rules::entry::ACCESS_FORM) {
        access_of_habit(text)?.name().to_owned()
    } else {
        return None;
    };
    Some(Fix::replace(finding.span.clone(), fixed))
}

/// The fix in XML, where numbers are digits without prefix.
pub(super) fn of_xml(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let text = source.text.get(finding.span.clone())?;
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"))?;
    let is_prefix = finding.problem.rule == &rules::xdd::PREFIX && !digits.is_empty();
    (is_prefix && digits.bytes().all(|digit| digit.is_ascii_hexdigit()))
        .then(|| Fix::replace(finding.span.clone(), digits))
}

fn flag(text: &str) -> Option<&'static str> {
    match text.to_ascii_lowercase().as_str() {
        "true" | "yes" => Some("1"),
        "false" | "no" => Some("0"),
        _ => None,
    }
}
