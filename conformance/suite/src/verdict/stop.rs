//! Why a case ends before its last line.

use super::{Breach, Reason};

/// Why a case ends before its last line.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Stop {
    /// After this breach the rest says nothing.
    Breach(Box<Breach>),
    /// The precondition could not be reached: nothing is known.
    Inconclusive(Reason),
    /// The device does not have what the case is about, or the user has not allowed it.
    NotApplicable(Reason),
    /// The tester or the bus failed, not the device.
    Error(Reason),
}

/// What a case returns: what it found wrong on its way is with the bench.
pub type Judged = Result<(), Stop>;

impl Stop {
    /// A breach of what a case needs first, but is not about: the precondition was not reached.
    #[must_use]
    pub fn unreached(self) -> Self {
        match self {
            Self::Breach(breach) => Self::Inconclusive(Reason::from(&*breach)),
            other => other,
        }
    }

    /// Why, in words.
    pub fn reason(&self) -> Reason {
        match self {
            Self::Breach(breach) => Reason::from(&**breach),
            Self::Inconclusive(reason) | Self::NotApplicable(reason) | Self::Error(reason) => reason.clone(),
        }
    }
}

/// Sees that a case has tried something: where nothing could be tried, nothing is known. `what` says what it needed.
///
/// # Errors
/// [`Stop::Inconclusive`] if it has not.
pub fn tried(times: usize, what: &'static str) -> Judged {
    if times > 0 {
        return Ok(());
    }
    Err(Stop::Inconclusive(Reason::new("the case tries what it is about", what, "none that the device answers so")))
}

impl From<Box<Breach>> for Stop {
    fn from(breach: Box<Breach>) -> Self {
        Self::Breach(breach)
    }
}

/// Turns what a case needs first, but is not about, into a precondition.
pub trait Precondition {
    /// What it gives where it holds.
    type Value;

    /// # Errors
    /// [`Stop::Inconclusive`] where it does not hold.
    fn or_inconclusive(self) -> Result<Self::Value, Stop>;
}

impl<T, E: Into<Stop>> Precondition for Result<T, E> {
    type Value = T;

    fn or_inconclusive(self) -> Result<T, Stop> {
        self.map_err(|stop| stop.into().unreached())
    }
}
