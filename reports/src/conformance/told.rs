//! The texts and values that all reports show for a breach, and for the reason why a case ended early.

use canvass_suite::runner::CaseReport;
use canvass_suite::situation::Situation;
use canvass_suite::verdict::{Authority, Excuse, Kind, Reason, Ruled};
use canvass_traces::Timestamp;

/// A breach or the end of a case.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Told {
    /// The verdict that follows for the case.
    pub kind: Kind,
    /// The required behaviour.
    pub duty: String,
    /// The expected answer.
    pub expected: String,
    /// The actual answer.
    pub found: String,
    /// The object and the actual answer, as a waiver names them. `None` for the end of a case.
    pub breach: Option<Named>,
    /// The waiver or device sheet that announces the breach, and its words.
    pub excuse: Option<Excuse>,
    /// The time of the breach.
    pub seen: Option<Timestamp>,
}

/// A breach in the names that device sheets and waivers use.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Named {
    /// The object or service, such as `1016h:01`, `heartbeat` or `device`.
    pub subject: String,
    /// The actual answer, such as `abort 0609 0030h` or `silence`.
    pub does: String,
    /// The situation, if it is one of the table of allowed answers.
    pub situation: Option<&'static str>,
}

impl Told {
    /// All breaches and the end of a case, the worst first.
    pub fn all(report: &CaseReport) -> Vec<Self> {
        let breaches = report.verdict.breaches().iter().map(Self::of);
        let end = report.verdict.end().map(|end| Self::end(end.kind(), end.reason()));
        let mut all: Vec<Self> = breaches.chain(end).collect();
        all.sort_by_key(|told| std::cmp::Reverse(told.kind.badness()));
        all
    }

    fn of(ruled: &Ruled) -> Self {
        let breach = &ruled.breach;
        let situation = breach.row().map(Situation::id);
        let named = Named { subject: breach.subject.to_string(), does: breach.actual.to_string(), situation };
        let reason = Reason::from(breach);
        let (excuse, seen) = (ruled.excuse.clone(), breach.seen);
        Self { breach: Some(named), excuse, seen, ..Self::end(ruled.kind(), &reason) }
    }

    fn end(kind: Kind, reason: &Reason) -> Self {
        let Reason { duty, expected, actual, .. } = reason.clone();
        Self { kind, duty, expected, found: actual, breach: None, excuse: None, seen: None }
    }

    /// A label for the document that announces the breach.
    pub const fn authority(&self) -> &'static str {
        match &self.excuse {
            Some(Excuse { by: Authority::Waiver { .. }, .. }) => "Waiver",
            _ => "Documented",
        }
    }

    /// The line at which the waiver begins that excuses the breach.
    pub const fn waiver_line(&self) -> Option<usize> {
        match &self.excuse {
            Some(Excuse { by: Authority::Waiver { line }, .. }) => Some(*line),
            _ => None,
        }
    }

    /// The lines of a waiver that would accept the breach. `None` if there is nothing to waive.
    pub fn waiver(&self) -> Option<String> {
        let Named { subject, does, .. } = self.breach.as_ref().filter(|_| self.kind == Kind::Fail)?;
        Some(format!("object = {subject:?}, does = {does:?}"))
    }
}
