//! Dates and times in the forms of CiA 306 and XML.

/// The date in the form of CiA 306, mm-dd-yyyy. The text has the year first, or dots as in German; `None` if the day is
/// ambiguous.
pub(super) fn eds_date(text: &str) -> Option<String> {
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

/// The time in the form of CiA 306, hh:mm(AM|PM), from a time with 24 hours, with seconds, or with a blank before AM
/// and PM.
pub(super) fn eds_time(text: &str) -> Option<String> {
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

/// Whether the text is a date in the form of CiA 306: mm-dd-yyyy.
pub(super) fn is_eds_date(text: &str) -> bool {
    eds_date(text).is_none() && xml_date(text).is_some()
}

/// Whether the text is a time in the form of CiA 306: hh:mm(AM|PM). An hour may have one digit.
pub(super) fn is_eds_time(text: &str) -> bool {
    let upper = text.to_ascii_uppercase();
    eds_time(text).is_some_and(|time| time == upper || time.strip_prefix('0') == Some(&upper))
}

/// The date in the form of XML, yyyy-mm-dd, from the form of XML or CiA 306.
pub(super) fn xml_date(text: &str) -> Option<String> {
    let own = eds_date(text);
    let (month_day, year) = own.as_deref().unwrap_or(text).rsplit_once('-').filter(|(_, year)| year.len() == 4)?;
    let (month, day) = month_day.split_once('-').filter(|(month, day)| month.len() == 2 && day.len() == 2)?;
    let turned = format!("{year}-{month}-{day}");
    // A date is accepted only if converting it back gives the same date.
    (eds_date(&turned).as_deref() == Some(own.as_deref().unwrap_or(text))).then_some(turned)
}

/// The time in the form of XML, hh:mm:ss, from the form of XML or CiA 306.
pub(super) fn xml_time(text: &str) -> Option<String> {
    let own = eds_time(text)?;
    let (clock, half) = own.split_at_checked(5)?;
    let (hour, minute) = clock.split_once(':')?;
    let hour = hour.parse::<u32>().ok()? % 12 + if half == "PM" { 12 } else { 0 };
    Some(format!("{hour:02}:{minute}:00"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_turned_where_the_day_is_certain() {
        assert_eq!(eds_date("2026-11-21").as_deref(), Some("11-21-2026"));
        assert_eq!(eds_date("2026/1/2").as_deref(), Some("01-02-2026"));
        assert_eq!(eds_date("21.11.2026").as_deref(), Some("11-21-2026"));
        for text in ["11/21/2026", "21-11-2026", "2026-13-01", "today", "", "1-2"] {
            assert_eq!(eds_date(text), None, "{text}");
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
            assert_eq!(eds_time(text).as_deref(), Some(expected), "{text}");
        }
        for text in ["24:00", "16:00PM", "0:00AM", "1:2:3:4", "12", "", "xx:yy", "1:60"] {
            assert_eq!(eds_time(text), None, "{text}");
        }
    }

    #[test]
    fn the_form_of_the_standard_is_told_from_others() {
        for date in ["11-21-2026", "01-31-1999", "12-01-2026"] {
            assert!(is_eds_date(date), "{date}");
        }
        for date in ["2026-11-21", "21-11-2026", "11-32-2026", "00-21-2026", "11-21-26", "11/21/2026", "1-2-2026", ""] {
            assert!(!is_eds_date(date), "{date}");
        }
        for time in ["09:00PM", "9:00am", "12:59AM"] {
            assert!(is_eds_time(time), "{time}");
        }
        for time in ["21:00", "09:00:00", "16:23PM", "09:60AM", "09:00 PM", "00:10AM", "noon", ""] {
            assert!(!is_eds_time(time), "{time}");
        }
    }

    #[test]
    fn dates_and_times_of_xml_mean_the_same() {
        assert_eq!(xml_date("11-21-2026").as_deref(), Some("2026-11-21"));
        assert_eq!(xml_date("2026-11-21").as_deref(), Some("2026-11-21"));
        for text in ["21-11-2026", "1-2-2026", "", "x", "11-21-26"] {
            assert_eq!(xml_date(text), None, "{text}");
        }
        for (text, expected) in
            [("09:00PM", "21:00:00"), ("12:05AM", "00:05:00"), ("12:30PM", "12:30:00"), ("9:07", "09:07:00")]
        {
            assert_eq!(xml_time(text).as_deref(), Some(expected), "{text}");
            assert_eq!(xml_time(expected).as_deref(), Some(expected));
        }
        assert_eq!(xml_time("noon"), None);
    }
}
