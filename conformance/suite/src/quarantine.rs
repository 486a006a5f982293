//! Quarantine: cases that are known to be flaky, whose failures are shown and do not count until a day.
//!
//! ```toml
//! [[quarantine]]
//! case = "301/heartbeat/period"           # an id or a pattern with *
//! owner = "Ann"                           # who looks into it
//! reason = "flaky on sample 3, ticket 12"
//! until = 2027-06-30                      # the last day on which it holds
//! ```
//!
//! A waiver accepts what a device does; a quarantine accepts nothing: it gives somebody time to find out. So it needs an owner
//! and an end.

use crate::glob;
use crate::verdict::Kind;
use serde::Deserialize;
use std::fmt;
use toml::value::Datetime;

/// Cases whose failures do not count until a day.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Quarantine {
    /// Where it begins in its file, from 1.
    pub line: usize,
    /// An id, or a pattern with `*`.
    pub case: String,
    /// Who looks into it.
    pub owner: String,
    /// Why the case is quarantined.
    pub reason: String,
    /// The last day on which it holds, `YYYY-MM-DD`.
    pub until: String,
}

/// As it stands in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct QuarantineRow {
    case: String,
    owner: String,
    reason: String,
    until: Datetime,
}

impl QuarantineRow {
    /// The quarantine that begins at that line; else what is wrong with it. Whether there is such a case is for the reader of the
    /// file to see.
    pub fn read(self, line: usize) -> Result<Quarantine, String> {
        let Self { case, owner, reason, until } = self;
        if reason.trim().is_empty() || owner.trim().is_empty() {
            return Err("expected a reason and an owner: a quarantine ends when somebody has looked into it".to_owned());
        }
        Ok(Quarantine { line, case, owner, reason, until: day(until)? })
    }
}

/// A day of a file, `YYYY-MM-DD`.
pub(crate) fn day(date: Datetime) -> Result<String, String> {
    match date {
        Datetime { date: Some(date), time: None, .. } => Ok(date.to_string()),
        other => Err(format!("expected a day such as 2027-06-30, found {other}")),
    }
}

impl Quarantine {
    /// Whether it is over on that day (`YYYY-MM-DD`).
    pub fn has_expired(&self, today: &str) -> bool {
        self.until.as_str() < today
    }

    /// Whether it keeps a case that ended so from counting.
    pub fn holds(&self, case: &str, kind: Kind) -> bool {
        matches!(kind, Kind::Fail | Kind::Error | Kind::Inconclusive) && glob::matches(&self.case, case)
    }
}

/// `in quarantine until 2027-06-30 (Ann): flaky on sample 3`.
impl fmt::Display for Quarantine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "in quarantine until {} ({}): {}", self.until, self.owner, self.reason)
    }
}
