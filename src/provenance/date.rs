//! The date of a report: from the clock or, without a live bus, a given date.

use super::Subject;
use anyhow::{Result, anyhow, bail};
use canvass_reports::provenance::Date;
use jiff::civil::{self, DateTime};
use jiff::tz::TimeZone;
use jiff::{Timestamp, Zoned};
use std::str::FromStr;

/// The value of `--date`, with its zone, or in UTC.
#[derive(Clone, Debug)]
pub struct GivenDate(Zoned);

impl FromStr for GivenDate {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let with_zone = || text.parse::<Zoned>().ok();
        let with_offset = || {
            let at: Timestamp = text.parse().ok()?;
            let offset = jiff::fmt::temporal::Pieces::parse(text).ok()?.to_numeric_offset()?;
            Some(at.to_zoned(TimeZone::fixed(offset)))
        };
        let in_utc = |at: DateTime| at.to_zoned(TimeZone::UTC).ok();
        let without = || in_utc(text.parse().ok()?).filter(|_| text.contains('T'));
        let day = || in_utc(text.parse::<civil::Date>().ok()?.at(0, 0, 0, 0));
        let date = with_zone().or_else(with_offset).or_else(without).or_else(day);
        date.map(Self).ok_or_else(|| anyhow!("expected a date such as 2026-11-22T14:00:00+01:00, found \"{text}\""))
    }
}

/// The environment variable for reproducible builds: seconds since 1970.
const EPOCH: &str = "SOURCE_DATE_EPOCH";

/// The date of a report on `subject`; `None` for a simulated run without a given date, so that its report is
/// reproducible.
pub fn of(given: Option<&GivenDate>, subject: Subject<'_>) -> Result<Option<Date>> {
    match (subject, given) {
        (Subject::LiveBus(_), Some(_)) => {
            bail!("--date is for simulated buses and files: reports on a live bus have the date of the clock")
        }
        (Subject::LiveBus(_), None) => Ok(Some(told(&Zoned::now()))),
        (_, Some(GivenDate(date))) => Ok(Some(told(date))),
        (Subject::SimulatedBus(_), None) => Ok(of_environment()?.as_ref().map(told)),
        (Subject::Files, None) => Ok(Some(told(&of_environment()?.unwrap_or_else(Zoned::now)))),
    }
}

/// The current date, or the date of `SOURCE_DATE_EPOCH`.
pub fn of_file() -> Result<Zoned> {
    Ok(of_environment()?.unwrap_or_else(Zoned::now))
}

fn of_environment() -> Result<Option<Zoned>> {
    let Some(text) = std::env::var_os(EPOCH).filter(|text| !text.is_empty()) else { return Ok(None) };
    let seconds = text.to_str().and_then(|text| text.parse().ok());
    let at = seconds.and_then(|seconds| Timestamp::from_second(seconds).ok());
    let at = at.ok_or_else(|| anyhow!("{EPOCH}: expected seconds since 1970, found \"{}\"", text.display()))?;
    Ok(Some(at.to_zoned(TimeZone::UTC)))
}

/// A date in whole seconds.
fn told(at: &Zoned) -> Date {
    let zone = at.time_zone();
    let name = zone.iana_name().map_or_else(|| at.offset().to_string(), str::to_owned);
    Date { rfc3339: at.strftime("%Y-%m-%dT%H:%M:%S%:z").to_string(), zone: name }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_as_typed() {
        let parsed = |text: &str| told(&text.parse::<GivenDate>().unwrap().0);
        let date = |rfc3339: &str, zone: &str| Date { rfc3339: rfc3339.to_owned(), zone: zone.to_owned() };
        let winter = "2026-11-22T14:00:00+01:00";
        assert_eq!(parsed("2026-11-22T14:00:00+01:00[Europe/Berlin]"), date(winter, "Europe/Berlin"));
        assert_eq!(parsed(winter), date(winter, "+01"));
        assert_eq!(parsed("2026-11-22T13:00:00Z").rfc3339, "2026-11-22T13:00:00+00:00");
        assert_eq!(parsed("2026-11-22T13:00:00"), date("2026-11-22T13:00:00+00:00", "UTC"));
        assert_eq!(parsed("2026-11-22"), date("2026-11-22T00:00:00+00:00", "UTC"));
        for wrong in ["", "today", "22.11.2026", "2026-13-01"] {
            assert!(wrong.parse::<GivenDate>().is_err(), "{wrong}");
        }
    }
}
