//! The waiver file: failures that the user of a device puts up with, each with a reason.
//!
//! ```toml
//! [[waiver]]
//! case = "301/pdo/mapping/*"              # an id or a pattern with *
//! reason = "mapping is fixed, ticket 4711"
//! object = "1A00:01"                      # optional: only failures that name this object
//! expires = 2027-06-30                    # optional: the last day on which the waiver holds
//! ```
//!
//! A waived failure has the verdict *deviation*. A waiver for a case that does not exist is an error; one that
//! explained nothing is reported, and so is one that has expired: waivers must not outlive what they are for.

use crate::bench::Deviation;
use crate::catalogue;
use crate::runner::CaseReport;
use crate::verdict::Authority;
use serde::Deserialize;
use std::collections::BTreeSet;
use toml::Spanned;
use toml::value::Datetime;

/// The waivers of a file.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Waivers {
    waivers: Vec<Waiver>,
}

/// One of them.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Waiver {
    /// Where it begins, from 1.
    pub line: usize,
    /// An id, or a pattern with `*`.
    pub case: String,
    /// Why the failure is put up with.
    pub reason: String,
    /// Only failures that name this object, as the reports write it: `1016h` or `1016h:01`.
    pub object: Option<String>,
    /// The last day on which it holds, `YYYY-MM-DD`.
    pub expires: Option<String>,
}

/// What is wrong with a waiver file.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("line {line}: {problem}")]
pub struct BadWaiver {
    /// From 1.
    pub line: usize,
    /// What was expected and what was found.
    pub problem: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    waiver: Vec<Spanned<Row>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Row {
    case: String,
    reason: String,
    object: Option<String>,
    expires: Option<Datetime>,
}

impl Waivers {
    /// Reads a file.
    ///
    /// # Errors
    /// [`BadWaiver`] with the line: no TOML, an unknown or missing key, an empty reason, a case that does not exist, a
    /// date or an object that is none.
    pub fn read(text: &str) -> Result<Self, BadWaiver> {
        let file: File = toml::from_str(text).map_err(|error| BadWaiver {
            line: error.span().map_or(1, |span| line_of(text, span.start)),
            problem: error.message().to_owned(),
        })?;
        let waivers = file.waiver.into_iter().map(|row| {
            let line = line_of(text, row.span().start);
            waiver(line, row.into_inner()).map_err(|problem| BadWaiver { line, problem })
        });
        Ok(Self { waivers: waivers.collect::<Result<_, _>>()? })
    }

    /// What they explain on that day (`YYYY-MM-DD`): those that have not expired.
    pub fn deviations(&self, today: &str) -> Vec<Deviation> {
        let valid = self.waivers.iter().filter(|waiver| !waiver.has_expired(today));
        valid.map(Waiver::deviation).collect()
    }

    /// A sentence about each waiver that did nothing in a run: it has expired, or no failure of the cases that ran was
    /// its.
    pub fn idle(&self, today: &str, reports: &[&CaseReport]) -> Vec<String> {
        let used: BTreeSet<Option<Authority>> = reports.iter().map(|report| report.verdict.authority()).collect();
        let idle = self.waivers.iter().filter_map(|waiver| {
            let Waiver { line, case, .. } = waiver;
            let ran = reports.iter().any(|r| r.verdict.kind().is_executed() && catalogue::matches(case, r.case.id));
            if waiver.has_expired(today) {
                let day = waiver.expires.as_deref().unwrap_or_default();
                return Some(format!("the waiver for {case} (line {line}) has expired on {day}"));
            }
            let is_used = used.contains(&Some(Authority::Waiver { line: *line }));
            (ran && !is_used).then(|| format!("the waiver for {case} (line {line}) was not needed: nothing failed"))
        });
        idle.collect()
    }
}

impl Waiver {
    fn has_expired(&self, today: &str) -> bool {
        self.expires.as_deref().is_some_and(|last| last < today)
    }

    fn deviation(&self) -> Deviation {
        let until = self.expires.as_ref().map(|day| format!(", until {day}")).unwrap_or_default();
        Deviation {
            case: self.case.clone(),
            object: self.object.clone(),
            documented: format!("waived: {} (line {}{until})", self.reason, self.line),
            by: Authority::Waiver { line: self.line },
        }
    }
}

fn waiver(line: usize, row: Row) -> Result<Waiver, String> {
    let Row { case, reason, object, expires } = row;
    if reason.trim().is_empty() {
        return Err("expected a reason: a waiver says why the failure is put up with".to_owned());
    }
    if !catalogue::cases().iter().any(|known| catalogue::matches(&case, known.id)) {
        return Err(format!("no case is called \"{case}\": `canvass list cases` shows them"));
    }
    let object = object.as_deref().map(shown_object).transpose()?;
    let expires = match expires {
        Some(Datetime { date: Some(date), time: None, .. }) => Some(date.to_string()),
        Some(other) => return Err(format!("expected a day such as 2027-06-30, found {other}")),
        None => None,
    };
    Ok(Waiver { line, case, reason, object, expires })
}

/// `1016` or `1016:01` as reports write it: `1016h`, `1016h:01`.
fn shown_object(text: &str) -> Result<String, String> {
    let (index, sub) = text.split_once(':').map_or((text, None), |(index, sub)| (index, Some(sub)));
    let index = index.trim_end_matches(['h', 'H']);
    let parsed = u16::from_str_radix(index, 16).ok().map(|index| format!("{index:04X}h"));
    let shown = match (parsed, sub) {
        (Some(index), None) => Some(index),
        (Some(index), Some(sub)) => u8::from_str_radix(sub, 16).ok().map(|sub| format!("{index}:{sub:02X}")),
        (None, _) => None,
    };
    shown.ok_or_else(|| format!("expected an object such as \"1016\" or \"1016:01\", found \"{text}\""))
}

/// The line of a byte, from 1.
fn line_of(text: &str, at: usize) -> usize {
    1 + text.bytes().take(at).filter(|&byte| byte == b'\n').count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::Reason;

    const FILE: &str = "# ours\n\n[[waiver]]\ncase = \"301/heartbeat/*\"\nreason = \"slow timer\"\n\n\
        [[waiver]]\ncase = \"301/identity/names\"\nreason = \"ticket 7\"\nobject = \"1008\"\nexpires = 2027-06-30\n";

    #[test]
    fn waivers_explain_their_cases_until_they_expire() {
        let waivers = Waivers::read(FILE).unwrap();
        let names = catalogue::find("301/identity/names").unwrap();
        let reason = |duty: &str| Reason::new(duty, "", "");
        let explains = |today: &str, duty: &str| {
            waivers.deviations(today).iter().any(|deviation| deviation.explains(names, &reason(duty)))
        };
        assert!(explains("2027-06-30", "1008h:00 is printable"));
        assert!(!explains("2027-06-30", "1009h:00 is printable"), "another object");
        assert!(!explains("2027-07-01", "1008h:00 is printable"), "expired");
        assert_eq!(waivers.deviations("2027-01-01")[1].by, Authority::Waiver { line: 7 });
        assert!(waivers.idle("2028-01-01", &[])[0].contains("expired on 2027-06-30"));
    }

    #[test]
    fn mistakes_are_named_with_their_line() {
        let with = |from: &str, to: &str| Waivers::read(&FILE.replace(from, to)).unwrap_err();
        for (from, to, line, says) in [
            ("\"slow timer\"", "\" \"", 3, "expected a reason"),
            ("reason = \"slow timer\"\n", "", 3, "missing field `reason`"),
            ("301/identity/names", "301/identity/nmaes", 7, "canvass list cases"),
            ("expires =", "until =", 11, "unknown field `until`"),
            ("2027-06-30", "12:00:00", 7, "expected a day"),
            ("\"1008\"", "\"name\"", 7, "expected an object"),
            ("case = \"301/heartbeat/*\"", "case = \"301", 4, ""),
        ] {
            let error = with(from, to);
            assert!(error.line == line && error.problem.contains(says), "{to}: {error}");
        }
    }
}
