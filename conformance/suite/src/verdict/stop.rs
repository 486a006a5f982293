//! Reasons why a case ends before its last line.

use super::{Breach, Lack, Reason};

/// The reason why a case ends before its last line.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Stop {
    /// After this breach the rest of the case would prove nothing.
    Breach(Box<Breach>),
    /// The precondition could not be reached, so nothing is known.
    Inconclusive(Reason),
    /// The device lacks the feature that the case tests, or the user has not allowed the case.
    NotApplicable(Reason),
    /// The tester or the bus failed, not the device.
    Error(Reason),
}

/// The result of a case. The bench holds the breaches that the case has recorded before.
pub type Judged = Result<(), Stop>;

impl Stop {
    /// Turns a breach of something that the case needs but does not test into an unreached precondition.
    #[must_use]
    pub fn unreached(self) -> Self {
        match self {
            Self::Breach(breach) if breach.compares_measurements => {
                Self::Inconclusive(Reason::from(&*breach).for_lack_of(Lack::Steadiness))
            }
            Self::Breach(breach) => Self::Inconclusive(Reason::from(&*breach)),
            other => other,
        }
    }

    /// The reason in words.
    pub fn reason(&self) -> Reason {
        match self {
            Self::Breach(breach) => Reason::from(&**breach),
            Self::Inconclusive(reason) | Self::NotApplicable(reason) | Self::Error(reason) => reason.clone(),
        }
    }
}

/// Requires that a case has tried something: without an attempt nothing is known. `what` names the missing thing.
///
/// # Errors
/// [`Stop::Inconclusive`] if `times` is 0.
pub fn tried(times: usize, what: &'static str) -> Judged {
    if times > 0 {
        return Ok(());
    }
    Err(Stop::Inconclusive(Reason::new("the case makes at least one attempt", what, "none")))
}

impl From<Box<Breach>> for Stop {
    fn from(breach: Box<Breach>) -> Self {
        Self::Breach(breach)
    }
}

/// Turns a requirement that the case needs but does not test into a precondition.
pub trait Precondition {
    /// The value of the precondition if it is met.
    type Value;

    /// # Errors
    /// [`Stop::Inconclusive`] if the precondition is not met.
    fn or_inconclusive(self) -> Result<Self::Value, Stop>;
}

impl<T, E: Into<Stop>> Precondition for Result<T, E> {
    type Value = T;

    fn or_inconclusive(self) -> Result<T, Stop> {
        self.map_err(|stop| stop.into().unreached())
    }
}
