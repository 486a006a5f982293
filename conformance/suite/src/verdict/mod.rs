//! The outcomes of cases.
//!
//! A case reports [`Breach`]es to its bench and ends with [`Judged`]. The runner compares each breach with the
//! announcements of the device's manual and its user, and makes the [`Verdict`] from both.

mod breach;
mod deviation;
mod stop;

pub use breach::{Allowed, Breach, Check, Grade, When, observed, observed_response};
pub use deviation::Deviation;
pub use stop::{Judged, Precondition, Stop, tried};

use std::fmt;

/// The outcome of a case.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Verdict {
    breaches: Vec<Ruled>,
    end: Option<End>,
}

/// A breach with its excuse.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Ruled {
    /// The breach.
    pub breach: Breach,
    /// The excuse, if the breach is announced.
    pub excuse: Option<Excuse>,
}

/// The announcement of a difference of the device from the standard. It excuses a breach that shows this difference.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Excuse {
    /// The text of the documentation or the waiver, with its source.
    pub documented: String,
    /// The authority that announces the difference.
    pub by: Authority,
}

/// The reason why a case ended early.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum End {
    /// The precondition could not be reached, so nothing is known.
    Inconclusive(Reason),
    /// The device lacks the feature that the case tests, or the user has not allowed the case.
    NotApplicable(Reason),
    /// The tester or the bus failed, not the device.
    Error(Reason),
}

/// The authority that announces a difference of the device from the standard.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Authority {
    /// The manufacturer: the device's own manual.
    Manual,
    /// The user, by a waiver in the waiver file.
    Waiver {
        /// The line of the waiver file, counted from 1.
        line: usize,
    },
}

/// The reason for a verdict.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Reason {
    /// The required behaviour in one sentence.
    pub duty: String,
    /// The exact answer, value or time that was expected.
    pub expected: String,
    /// The actual answer, value or time.
    pub actual: String,
    /// The condition whose lack prevented a verdict.
    pub lack: Lack,
}

/// A condition whose lack prevents a verdict.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Lack {
    /// A feature of the device or the bus.
    #[default]
    Feature,
    /// A description of the device.
    Description,
    /// The user's permission.
    Permission,
    /// A bus on which nobody else uses the device.
    Quiet,
    /// A device that gets processor time when it needs it.
    Promptness,
    /// A measured quantity that stays, or changes steadily.
    Steadiness,
}

/// The kinds of verdict, for counting and for names.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Kind {
    /// The device behaves as the standard says.
    Pass,
    /// The device violates the standard, but CiA's own test tool accepts it.
    Tolerated,
    /// The device differs from the standard in the way that its own documentation or its user announces.
    Deviation,
    /// The device violates the standard.
    Fail,
    /// The precondition could not be reached, so nothing is known.
    Inconclusive,
    /// The device lacks the feature that the case tests, or the user has not allowed the case.
    NotApplicable,
    /// The tester or the bus failed, not the device.
    Error,
}

impl Kind {
    /// All kinds, in the order in which summaries list them.
    pub const ALL: [Self; 7] = [
        Self::Pass,
        Self::Tolerated,
        Self::Deviation,
        Self::Fail,
        Self::Inconclusive,
        Self::NotApplicable,
        Self::Error,
    ];

    /// The kind with this name in JSON.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The name of the kind in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Tolerated => "tolerated",
            Self::Deviation => "deviation",
            Self::Fail => "fail",
            Self::Inconclusive => "inconclusive",
            Self::NotApplicable => "not_applicable",
            Self::Error => "error",
        }
    }

    /// The name of the kind for people.
    pub const fn title(self) -> &'static str {
        match self {
            Self::NotApplicable => "not applicable",
            _ => self.name(),
        }
    }

    /// The severity of the kind, for choosing the worst of several outcomes: a case that failed once has failed.
    pub const fn badness(self) -> u8 {
        match self {
            Self::Pass => 0,
            Self::Tolerated => 1,
            Self::Deviation => 2,
            Self::NotApplicable => 3,
            Self::Inconclusive => 4,
            Self::Error => 5,
            Self::Fail => 6,
        }
    }

    /// Whether the case ran to its end and says something about the device.
    pub const fn is_executed(self) -> bool {
        matches!(self, Self::Pass | Self::Tolerated | Self::Deviation | Self::Fail)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.title())
    }
}

impl Verdict {
    /// The verdict on a case with these breaches and this end.
    pub fn new(breaches: Vec<Ruled>, end: Option<End>) -> Self {
        Self { breaches, end }
    }

    /// The verdict of a case without breach.
    pub const fn pass() -> Self {
        Self { breaches: Vec::new(), end: None }
    }

    /// The verdict of a case whose precondition could not be reached.
    pub const fn inconclusive(reason: Reason) -> Self {
        Self { breaches: Vec::new(), end: Some(End::Inconclusive(reason)) }
    }

    /// The verdict of a case whose feature the device lacks.
    pub const fn not_applicable(reason: Reason) -> Self {
        Self { breaches: Vec::new(), end: Some(End::NotApplicable(reason)) }
    }

    /// The verdict of a case in which the tester or the bus failed.
    pub const fn error(reason: Reason) -> Self {
        Self { breaches: Vec::new(), end: Some(End::Error(reason)) }
    }

    /// The breaches in the order in which they were found.
    pub fn breaches(&self) -> &[Ruled] {
        &self.breaches
    }

    /// The reason why the case ended early.
    pub const fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    /// The kind of the verdict: the worst of the breaches and of the end.
    pub fn kind(&self) -> Kind {
        let breaches = self.breaches.iter().map(Ruled::kind);
        let kinds = breaches.chain(self.end.as_ref().map(End::kind));
        kinds.max_by_key(|kind| kind.badness()).unwrap_or(Kind::Pass)
    }

    /// The decisive breach: the first of the worst.
    pub fn worst(&self) -> Option<&Ruled> {
        let kind = self.kind();
        self.breaches.iter().find(|ruled| ruled.kind() == kind)
    }

    /// The reason for the verdict; `None` for a pass.
    pub fn reason(&self) -> Option<Reason> {
        let kind = self.kind();
        if kind == Kind::Pass {
            return None;
        }
        let end = self.end.as_ref().filter(|end| end.kind() == kind).map(|end| end.reason().clone());
        end.or_else(|| self.worst().map(|ruled| Reason::from(&ruled.breach)))
    }

    /// The documentation that announces the decisive deviation.
    pub fn documented(&self) -> Option<&str> {
        let excuse = self.worst().filter(|_| self.kind() == Kind::Deviation)?.excuse.as_ref()?;
        Some(&excuse.documented)
    }

    /// The authority that announces the decisive deviation.
    pub fn authority(&self) -> Option<Authority> {
        self.worst().filter(|_| self.kind() == Kind::Deviation)?.excuse.as_ref().map(|excuse| excuse.by)
    }
}

impl Ruled {
    /// The kind of verdict that this breach alone would cause.
    pub const fn kind(&self) -> Kind {
        match (self.breach.grade, &self.excuse) {
            (Grade::Open, _) => Kind::Pass,
            (Grade::Tolerated, _) => Kind::Tolerated,
            (Grade::Wrong, Some(_)) => Kind::Deviation,
            (Grade::Wrong, None) => Kind::Fail,
        }
    }
}

impl End {
    /// The kind of verdict of a case that ended this way without breach.
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Inconclusive(_) => Kind::Inconclusive,
            Self::NotApplicable(_) => Kind::NotApplicable,
            Self::Error(_) => Kind::Error,
        }
    }

    /// The reason in words.
    pub const fn reason(&self) -> &Reason {
        match self {
            Self::Inconclusive(reason) | Self::NotApplicable(reason) | Self::Error(reason) => reason,
        }
    }
}

impl Reason {
    /// A reason from the required, the expected and the actual behaviour.
    pub fn new(duty: impl Into<String>, expected: impl Into<String>, actual: impl Into<String>) -> Self {
        Self { duty: duty.into(), expected: expected.into(), actual: actual.into(), lack: Lack::Feature }
    }

    /// Sets the condition whose lack prevented a verdict.
    #[must_use]
    pub fn for_lack_of(self, lack: Lack) -> Self {
        Self { lack, ..self }
    }
}

/// `DUTY: expected EXPECTED, found ACTUAL`.
impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.duty, self.expected, self.actual)
    }
}

/// Success if `met`, otherwise the breach: the usual end of a check.
///
/// # Errors
/// The breach if not `met`.
pub fn demand(met: bool, breach: impl FnOnce() -> Breach) -> Check {
    if met { Ok(()) } else { Err(Box::new(breach())) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_bus::observation::{Observation, Subject};

    fn ruled(grade: Grade, excused: bool) -> Ruled {
        let breach = Breach { grade, ..Breach::new(Subject::Device, "it works").found(Observation::Silence) };
        let excuse = excused.then(|| Excuse { documented: "5.1".to_owned(), by: Authority::Manual });
        Ruled { breach, excuse }
    }

    #[test]
    fn the_worst_decides() {
        let kind = |breaches: &[Ruled], end: Option<End>| Verdict::new(breaches.to_vec(), end).kind();
        let (open, tolerated) = (ruled(Grade::Open, false), ruled(Grade::Tolerated, false));
        let (excused, wrong) = (ruled(Grade::Wrong, true), ruled(Grade::Wrong, false));
        assert_eq!(kind(&[], None), Kind::Pass);
        assert_eq!(kind(std::slice::from_ref(&open), None), Kind::Pass);
        assert_eq!(kind(&[open, tolerated.clone()], None), Kind::Tolerated);
        assert_eq!(kind(&[excused.clone(), tolerated], None), Kind::Deviation);
        assert_eq!(kind(&[excused.clone(), wrong.clone()], None), Kind::Fail, "an excuse hides nothing else");
        let unreached = Some(End::Inconclusive(Reason::default()));
        assert_eq!(kind(&[excused], unreached.clone()), Kind::Inconclusive);
        assert_eq!(kind(&[wrong], unreached), Kind::Fail, "what was seen was seen");
    }

    #[test]
    fn only_what_ran_to_an_end_counts_as_executed() {
        let executed: Vec<&str> = Kind::ALL.into_iter().filter(|k| k.is_executed()).map(Kind::name).collect();
        assert_eq!(executed, ["pass", "tolerated", "deviation", "fail"]);
    }
}
