//! Checks of limits: they must allow a value, and the values must be within them.

use super::object::{Entry, Setting};
use super::place::Place;
use super::problem::Problems;
use super::rules;
use super::value::Value;

/// The names of the limits' fields in one format of descriptions.
pub(super) struct Names {
    pub low: &'static str,
    pub high: &'static str,
    pub default: &'static str,
    pub configured: &'static str,
}

/// Corrects a high limit whose bits are all set in hexadecimal. In a signed type that is -1, but the author meant the
/// highest number.
pub(super) fn unwrap_high(entry: &mut Entry, place: Place<'_>, problems: &mut Problems) {
    let is_wrapped = number(&entry.high_limit) == Some(-1) && number(&entry.low_limit).is_none_or(|low| low > -1);
    if !is_wrapped {
        return;
    }
    let expected = "the highest number of the signed data type, such as 0x7F";
    problems.report(place, &rules::number::WRAPPED, expected, "all bits set, which is -1");
    let highest = entry.data_type.bits().and_then(|bits| 1_u64.checked_shl(bits - 1)).map(|bound| bound - 1);
    entry.high_limit = highest.and_then(|highest| Value::from_raw(entry.data_type, highest)).map(Setting::Fixed);
}

fn number(setting: &Option<Setting>) -> Option<i128> {
    setting.as_ref().and_then(Setting::fixed)?.as_number()
}

/// Checks the limits of a parsed entry, and its values against them.
pub(super) fn check<'a>(
    entry: &Entry,
    names: &Names,
    place: impl Fn(&'static str) -> Place<'a>,
    problems: &mut Problems,
) {
    let (low, high) = (number(&entry.low_limit), number(&entry.high_limit));
    if let (Some(low), Some(high)) = (low, high)
        && low > high
    {
        let found = format!("{low} and {high}");
        problems.report(place(names.low), &rules::entry::LIMITS, "a low limit up to the high limit", &found);
        return;
    }
    for (field, setting) in [(names.default, &entry.default), (names.configured, &entry.configured)] {
        let Some(value) = number(setting) else { continue };
        if low.is_some_and(|low| value < low) || high.is_some_and(|high| value > high) {
            let expected = "a value between LowLimit and HighLimit";
            problems.report(place(field), &rules::entry::BEYOND_LIMITS, expected, &value.to_string());
        }
    }
}

/// Whether a text is a hexadecimal number with only the digit F.
pub(super) fn is_all_ones(text: Option<&str>) -> bool {
    let digits = text.and_then(|text| text.trim().strip_prefix("0x").or_else(|| text.trim().strip_prefix("0X")));
    digits.is_some_and(|digits| !digits.is_empty() && digits.bytes().all(|digit| digit.eq_ignore_ascii_case(&b'F')))
}
