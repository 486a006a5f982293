//! How a case ends.

use std::fmt;

/// The outcome of a case.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Verdict {
    /// As the standard says.
    Pass,
    /// Not what the standard says, but accepted by CiA's own test tool.
    Tolerated(Reason),
    /// Differs from the standard as the device's own documentation says it does.
    Deviation {
        /// What was found.
        reason: Reason,
        /// What the documentation or the waiver says, and where.
        documented: String,
        /// Who says so.
        by: Authority,
    },
    /// Not as the standard says.
    Fail(Reason),
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
        /// From 1.
        line: usize,
    },
}

/// What a case returns. Both sides are verdicts, so that `?` ends a case early.
pub type Judged = Result<Verdict, Verdict>;

/// Why a verdict is what it is.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Reason {
    /// What had to happen, in one sentence.
    pub duty: String,
    /// The exact answer, value or time that would have been right.
    pub expected: String,
    /// What was there instead.
    pub actual: String,
}

/// The kinds of verdict, for counting and for names.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Kind {
    /// [`Verdict::Pass`].
    Pass,
    /// [`Verdict::Tolerated`].
    Tolerated,
    /// [`Verdict::Deviation`].
    Deviation,
    /// [`Verdict::Fail`].
    Fail,
    /// [`Verdict::Inconclusive`].
    Inconclusive,
    /// [`Verdict::NotApplicable`].
    NotApplicable,
    /// [`Verdict::Error`].
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
    /// The verdict's kind.
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Pass => Kind::Pass,
            Self::Tolerated(_) => Kind::Tolerated,
            Self::Deviation { .. } => Kind::Deviation,
            Self::Fail(_) => Kind::Fail,
            Self::Inconclusive(_) => Kind::Inconclusive,
            Self::NotApplicable(_) => Kind::NotApplicable,
            Self::Error(_) => Kind::Error,
        }
    }

    /// Why; a pass needs no reason.
    pub const fn reason(&self) -> Option<&Reason> {
        match self {
            Self::Pass => None,
            Self::Tolerated(reason)
            | Self::Deviation { reason, .. }
            | Self::Fail(reason)
            | Self::Inconclusive(reason)
            | Self::NotApplicable(reason)
            | Self::Error(reason) => Some(reason),
        }
    }

    /// Where the device's documentation announces the deviation.
    pub fn documented(&self) -> Option<&str> {
        match self {
            Self::Deviation { documented, .. } => Some(documented),
            _ => None,
        }
    }

    /// Who announces the deviation.
    pub const fn authority(&self) -> Option<Authority> {
        match self {
            Self::Deviation { by, .. } => Some(*by),
            _ => None,
        }
    }

    /// The same observation as the failure of a precondition: what a case needs first, but is not about.
    pub fn as_inconclusive(self) -> Self {
        match self {
            Self::Fail(reason) | Self::Tolerated(reason) => Self::Inconclusive(reason),
            other => other,
        }
    }

    /// Of two good verdicts the one that says more: `tolerated` outweighs `pass`.
    pub fn and(self, other: Self) -> Self {
        if self == Self::Pass { other } else { self }
    }
}

impl Reason {
    /// A reason from its three parts.
    pub fn new(duty: impl Into<String>, expected: impl Into<String>, actual: impl Into<String>) -> Self {
        Self { duty: duty.into(), expected: expected.into(), actual: actual.into() }
    }
}

/// `DUTY: expected EXPECTED, found ACTUAL`.
impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.duty, self.expected, self.actual)
    }
}

/// [`Verdict::Pass`] where `met`, else [`Verdict::Fail`]: the usual end of a check.
///
/// # Errors
/// The failure.
pub fn demand(met: bool, reason: impl FnOnce() -> Reason) -> Judged {
    if met { Ok(Verdict::Pass) } else { Err(Verdict::Fail(reason())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerated_outweighs_pass() {
        let tolerated = Verdict::Tolerated(Reason::default());
        assert_eq!(Verdict::Pass.and(tolerated.clone()), tolerated);
        assert_eq!(tolerated.clone().and(Verdict::Pass), tolerated);
        assert_eq!(Verdict::Pass.and(Verdict::Pass), Verdict::Pass);
    }

    #[test]
    fn only_what_ran_to_an_end_counts_as_executed() {
        let executed: Vec<&str> = Kind::ALL.into_iter().filter(|k| k.is_executed()).map(Kind::name).collect();
        assert_eq!(executed, ["pass", "tolerated", "deviation", "fail"]);
    }
}
