//! How a case ends.
//!
//! A case reports [`Breach`]es to its bench and ends with [`Judged`]; the runner holds each breach against what the
//! device's manual and its user announce, and makes the [`Verdict`] of both.

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

/// A breach, and who announces it.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Ruled {
    /// What was found wrong.
    pub breach: Breach,
    /// Who announces that the device does this.
    pub excuse: Option<Excuse>,
}

/// An announcement that a device differs from the standard in this.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Excuse {
    /// What the documentation or the waiver says, and where.
    pub documented: String,
    /// Who says so.
    pub by: Authority,
}

/// Why a case did not come to its own end.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum End {
    /// The precondition could not be reached: nothing is known.
    Inconclusive(Reason),
    /// The device does not have what the case is about, or the user has not allowed it.
    NotApplicable(Reason),
    /// The tester or the bus failed, not the device.
    Error(Reason),
}

/// Who announces that a device differs from the standard.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Authority {
    /// The manufacturer: the device's own manual.
    Manual,
    /// The user: a waiver that begins at that line of the waiver file.
    Waiver {
        /// The line of the waiver file, counted from 1.
        line: usize,
    },
}

/// Why a verdict is what it is.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Reason {
    /// What had to happen, in one sentence.
    pub duty: String,
    /// The exact answer, value or time that would have been right.
    pub expected: String,
    /// What was there instead.
    pub actual: String,
    /// What would help.
    pub lack: Lack,
}

/// What a case would need that could not be judged.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub enum Lack {
    /// Something of the device or the bus.
    #[default]
    Feature,
    /// A description of the device.
    Description,
    /// The user's permission.
    Permission,
    /// A bus on which nobody else uses the device.
    Quiet,
    /// A device that gets a processor when it needs one.
    Promptness,
}

/// The kinds of verdict, for counting and for names.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Kind {
    /// As the standard says.
    Pass,
    /// Not what the standard says, but accepted by CiA's own test tool.
    Tolerated,
    /// Differs from the standard as the device's own documentation, or its user, says it does.
    Deviation,
    /// Not as the standard says.
    Fail,
    /// The precondition could not be reached: nothing is known.
    Inconclusive,
    /// The device does not have what the case is about, or the user has not allowed it.
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

    /// The kind of that name in JSON.
    pub fn by_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// The word for it in JSON.
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

    /// The word for people.
    pub const fn title(self) -> &'static str {
        match self {
            Self::NotApplicable => "not applicable",
            _ => self.name(),
        }
    }

    /// How bad it is, for choosing the worst of several outcomes: a case that failed once has failed.
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

    /// Whether the case ran to an end and says something about the device.
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
    /// The verdict on a case that found this and ended so.
    pub fn new(breaches: Vec<Ruled>, end: Option<End>) -> Self {
        Self { breaches, end }
    }

    /// As the standard says.
    pub const fn pass() -> Self {
        Self { breaches: Vec::new(), end: None }
    }

    /// The precondition could not be reached.
    pub const fn inconclusive(reason: Reason) -> Self {
        Self { breaches: Vec::new(), end: Some(End::Inconclusive(reason)) }
    }

    /// The device does not have what the case is about.
    pub const fn not_applicable(reason: Reason) -> Self {
        Self { breaches: Vec::new(), end: Some(End::NotApplicable(reason)) }
    }

    /// The tester or the bus failed.
    pub const fn error(reason: Reason) -> Self {
        Self { breaches: Vec::new(), end: Some(End::Error(reason)) }
    }

    /// What was found wrong, in the order in which it was found.
    pub fn breaches(&self) -> &[Ruled] {
        &self.breaches
    }

    /// Why the case did not come to its own end.
    pub const fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    /// The verdict's kind: the worst of what was found and of how the case ended.
    pub fn kind(&self) -> Kind {
        let breaches = self.breaches.iter().map(Ruled::kind);
        let kinds = breaches.chain(self.end.as_ref().map(End::kind));
        kinds.max_by_key(|kind| kind.badness()).unwrap_or(Kind::Pass)
    }

    /// The breach that decides, the first of the worst.
    pub fn worst(&self) -> Option<&Ruled> {
        let kind = self.kind();
        self.breaches.iter().find(|ruled| ruled.kind() == kind)
    }

    /// The reason for the verdict; a pass has none.
    pub fn reason(&self) -> Option<Reason> {
        let kind = self.kind();
        if kind == Kind::Pass {
            return None;
        }
        let end = self.end.as_ref().filter(|end| end.kind() == kind).map(|end| end.reason().clone());
        end.or_else(|| self.worst().map(|ruled| Reason::from(&ruled.breach)))
    }

    /// Where the device's documentation announces the deviation that decides.
    pub fn documented(&self) -> Option<&str> {
        let excuse = self.worst().filter(|_| self.kind() == Kind::Deviation)?.excuse.as_ref()?;
        Some(&excuse.documented)
    }

    /// Who announces the deviation that decides.
    pub fn authority(&self) -> Option<Authority> {
        self.worst().filter(|_| self.kind() == Kind::Deviation)?.excuse.as_ref().map(|excuse| excuse.by)
    }
}

impl Ruled {
    /// What it would make of a case that found nothing else.
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
    /// What it makes of a case that found nothing wrong.
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Inconclusive(_) => Kind::Inconclusive,
            Self::NotApplicable(_) => Kind::NotApplicable,
            Self::Error(_) => Kind::Error,
        }
    }

    /// Why, in words.
    pub const fn reason(&self) -> &Reason {
        match self {
            Self::Inconclusive(reason) | Self::NotApplicable(reason) | Self::Error(reason) => reason,
        }
    }
}

impl Reason {
    /// A reason from its three parts.
    pub fn new(duty: impl Into<String>, expected: impl Into<String>, actual: impl Into<String>) -> Self {
        Self { duty: duty.into(), expected: expected.into(), actual: actual.into(), lack: Lack::Feature }
    }

    /// A description of the device, or the user's permission, would help.
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

/// Nothing wrong where `met`, else the breach: the usual end of a check.
///
/// # Errors
/// The breach.
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
