//! Values in another form: dates, times, flags, numbers, access types.

use super::{Fix, Source};
use crate::dictionary::check::Finding;
use crate::dictionary::eds::{access_of_habit, number};
use crate::dictionary::rules;

/// Of an EDS: the finding stands on the value.
pub(super) fn of(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let rule = finding.problem.rule;
    let text = source.get(&finding.span);
    let is = |other: &rules::Rule| rule == other;
    let mended = if is(&rules::file::DATE) {
        date(text)?
    } else if is(&rules::file::TIME) {
        time(text)?
    } else if is(&rules::field::FLAG) {
        flag(text)?.to_owned()
    } else if is(&rules::number::FORM) || is(&rules::number::NODE_ID_BEHIND) {
        flag(text).map(str::to_owned).or_else(|| number::in_form(text))?
    } else if is(&rules::entry::ACCESS_FORM) {
        access_of_habit(text)?.name().to_owned()
    } else {
        return None;
    };
    Some(Fix::replace(finding.span.clone(), mended))
}

/// Of XML: digits without prefix.
pub(super) fn of_xml(finding: &Finding, source: &Source<'_>) -> Option<Fix> {
    let text = source.get(&finding.span);
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"))?;
    let is_prefix = finding.problem.rule == &rules::xdd::PREFIX && !digits.is_empty();
    (is_prefix && digits.bytes().all(|digit| digit.is_ascii_hexdigit()))
        .then(|| Fix::replace(finding.span.clone(), digits))
}

/// Year first, or with dots as in German: which number is the day is certain.
fn date(text: &str) -> Option<String> {
    let parts = |separator| -> Option<[&str; 3]> { text.split(separator).collect::<Vec<_>>().try_into().ok() };
    let is_year = |text: &str| text.len() == 4;
    let (year, month, day) = match (parts('-').or_else(|| parts('/')), parts('.')) {
        (Some([year, month, day]), _) if is_year(year) => (year, month, day),
        (_, Some([day, month, year])) if is_year(year) => (year, month, day),
        _ => return None,
    };
    let number = |text: &str, most: u32| text.parse::<u32>().ok().filter(|number| (1..=most).contains(number));
    let (month, day) = (number(month, 12)?, number(day, 31)?);
    let year: u32 = year.parse().ok()?;
    Some(format!("{month:02}-{day:02}-{year:04}"))
}

/// With 24 hours, seconds, or a blank before AM and PM.
fn time(text: &str) -> Option<String> {
    let upper = text.to_ascii_uppercase();
    let (clock, half) = match (upper.strip_suffix("AM"), upper.strip_suffix("PM")) {
        (Some(clock), _) => (clock.trim(), Some("AM")),
        (_, Some(clock)) => (clock.trim(), Some("PM")),
        _ => (upper.trim(), None),
    };
    let mut parts = clock.split(':');
    let number = |text: Option<&str>, most: u32| {
        let text = text.filter(|text| (1..=2).contains(&text.len()))?;
        text.parse::<u32>().ok().filter(|&number| number <= most)
    };
    let (hour, minute) = (number(parts.next(), 23)?, number(parts.next(), 59)?);
    if parts.next().is_some_and(|seconds| number(Some(seconds), 59).is_none()) || parts.next().is_some() {
        return None;
    }
    let (hour, half) = match half {
        Some(half) => (hour, half),
        None if hour < 12 => (if hour == 0 { 12 } else { hour }, "AM"),
        None => (if hour == 12 { 12 } else { hour - 12 }, "PM"),
    };
    (1..=12).contains(&hour).then(|| format!("{hour:02}:{minute:02}{half}"))
}

fn flag(text: &str) -> Option<&'static str> {
    match text.to_ascii_lowercase().as_str() {
        "true" | "yes" => Some("1"),
        "false" | "no" => Some("0"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_turned_where_the_day_is_certain() {
        assert_eq!(date("2026-11-21").as_deref(), Some("11-21-2026"));
        assert_eq!(date("2026/1/2").as_deref(), Some("01-02-2026"));
        assert_eq!(date("21.11.2026").as_deref(), Some("11-21-2026"));
        for text in ["11/21/2026", "21-11-2026", "2026-13-01", "today", "", "1-2"] {
            assert_eq!(date(text), None, "{text}");
        }
    }

    #[test]
    fn times_get_twelve_hours() {
        let cases = [
            ("21:00", "09:00PM"),
            ("00:05", "12:05AM"),
            ("12:30", "12:30PM"),
            ("9:00 am", "09:00AM"),
            ("13:37:59", "01:37PM"),
            ("11:59", "11:59AM"),
        ];
        for (text, expected) in cases {
            assert_eq!(time(text).as_deref(), Some(expected), "{text}");
        }
        for text in ["24:00", "16:00PM", "0:00AM", "1:2:3:4", "12", "", "xx:yy", "1:60"] {
            assert_eq!(time(text), None, "{text}");
        }
    }
}
