//! What is reported about a case: each breach, and why it did not come to its own end, in the words and data of all reports.

use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::{Authority, Excuse, Kind, Reason, Ruled};
use canvass_traces::Timestamp;

/// One thing to tell of a case.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Told {
    /// What it makes of the case.
    pub kind: Kind,
    /// What had to happen.
    pub duty: String,
    /// What would have been right.
    pub expected: String,
    /// What came.
    pub found: String,
    /// What it is about and what came, as a waiver names them; not of an end.
    pub breach: Option<Named>,
    /// Who announces it, and in which words.
    pub excuse: Option<Excuse>,
    /// When it was seen.
    pub seen: Option<Timestamp>,
}

/// A breach by the names that manuals' sheets and waivers use.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Named {
    /// `1016h:01`, `heartbeat`, `device`.
    pub subject: String,
    /// `abort 0609 0030h`, `silence`.
    pub does: String,
}

impl Told {
    /// All of a case, the worst first.
    pub fn all(report: &CaseReport) -> Vec<Self> {
        let breaches = report.verdict.breaches().iter().map(Self::of);
        let end = report.verdict.end().map(|end| Self::end(end.kind(), end.reason()));
        let mut all: Vec<Self> = breaches.chain(end).collect();
        all.sort_by_key(|told| std::cmp::Reverse(told.kind.badness()));
        all
    }

    fn of(ruled: &Ruled) -> Self {
        let breach = &ruled.breach;
        let named = Named { subject: breach.subject.to_string(), does: breach.actual.to_string() };
        let reason = Reason::from(breach);
        let (excuse, seen) = (ruled.excuse.clone(), breach.seen);
        Self { breach: Some(named), excuse, seen, ..Self::end(ruled.kind(), &reason) }
    }

    fn end(kind: Kind, reason: &Reason) -> Self {
        let Reason { duty, expected, actual, .. } = reason.clone();
        Self { kind, duty, expected, found: actual, breach: None, excuse: None, seen: None }
    }

    /// Who announces it, as a label.
    pub const fn authority(&self) -> &'static str {
        match &self.excuse {
            Some(Excuse { by: Authority::Waiver { .. }, .. }) => "Waiver",
            _ => "Documented",
        }
    }

    /// Where the waiver begins that excuses it.
    pub const fn waiver_line(&self) -> Option<usize> {
        match &self.excuse {
            Some(Excuse { by: Authority::Waiver { line }, .. }) => Some(*line),
            _ => None,
        }
    }

    /// The lines of a waiver that would accept it; none where nothing is to be waived.
    pub fn waiver(&self) -> Option<String> {
        let Named { subject, does } = self.breach.as_ref().filter(|_| self.kind == Kind::Fail)?;
        Some(format!("object = {subject:?}, does = {does:?}"))
    }
}
