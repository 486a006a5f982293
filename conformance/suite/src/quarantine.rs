//! Quarantine: cases that are known to be flaky. Their failures are shown but do not count until a given day.
//!
//! ```toml
//! [[quarantine]]
//! case = "301/heartbeat/period"           # an id or a pattern with *
//! owner = "Ann"                           # who looks into it
//! reason = "flaky on sample 3, ticket 12"
//! until = 2027-06-30                      # the last day on which it holds
//! ```
//!
//! A waiver accepts a behaviour of the device. A quarantine accepts nothing, but gives somebody time to find out, so it
//! needs an owner and an end.

use crate::glob;
use crate::verdict::Kind;
use serde::Deserialize;
use std::fmt;
use toml::value::Datetime;

/// Cases whose failures do not count until a given day.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Quarantine {
    /// The line at which the quarantine begins in its file, from 1.
    pub line: usize,
    /// The id of a case, or a pattern with `*`.
    pub case: String,
    /// The person who investigates why the case is flaky.
    pub owner: String,
    /// The reason for the quarantine.
    pub reason: String,
    /// The last day of the quarantine, `YYYY-MM-DD`.
    pub until: String,
}

/// The quarantine as written in a file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct QuarantineRow {
    case: String,
    owner: String,
    reason: String,
    until: Datetime,
}

impl QuarantineRow {
    /// The quarantine that begins at this line, or its error. The reader of the file checks that the case exists.
    pub fn read(self, line: usize) -> Result<Quarantine, String> {
        let Self { case, owner, reason, until } = self;
        if reason.trim().is_empty() || owner.trim().is_empty() {
            return Err(
                "expected a reason and an owner: a quarantine ends when its owner has investigated the failure"
                    .to_owned(),
            );
        }
        Ok(Quarantine { line, case, owner, reason, until: day(until)? })
    }
}

/// A day in a file, as `YYYY-MM-DD`.
pub(crate) fn day(date: Datetime) -> Result<String, String> {
    match date {
        Datetime { date: Some(date), time: None, .. } => Ok(date.to_string()),
        other => Err(format!("expected a day such as 2027-06-30, found {other}")),
    }
}

impl Quarantine {
    /// Whether the quarantine is over on this day (`YYYY-MM-DD`).
    pub(crate) fn has_expired(&self, today: &str) -> bool {
        self.until.as_str() < today
    }

    /// Whether the quarantine keeps this verdict of the case from counting.
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
