//! What a check found wrong.

use super::Reason;
use crate::situation::Situation;
use canvass_bus::client::sdo::{Outcome, name};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Timestamp};
use std::borrow::Cow;
use std::fmt;

/// What a check found wrong: what it is about, when, what would have been right, what came.
///
/// [`Breach::subject`] and [`Breach::actual`] are what manuals' sheets and waivers are compared with; the words are for
/// people only.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Breach {
    /// What of the device it is about.
    pub subject: Subject,
    /// What the device was asked, or what happened to it.
    pub situation: When,
    /// What would have been right.
    pub allowed: Allowed,
    /// What came instead.
    pub actual: Observation,
    /// What came, in more words than the observation has: the other values, the frame.
    pub detail: Option<String>,
    /// How bad it is.
    pub grade: Grade,
    /// When it was seen, on the clock of the bus.
    pub seen: Option<Timestamp>,
    /// Of how many periods a time is the mean; 1: a single one.
    pub periods: u64,
}

/// How bad a breach is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Grade {
    /// The standard leaves it open: it is recorded.
    Open,
    /// Not what the standard says, but accepted by CiA's own test tool.
    Tolerated,
    /// Not what the standard says.
    Wrong,
}

/// The situation of a breach.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum When {
    /// One of the table of allowed answers, with what exactly was sent.
    Listed {
        /// The row.
        situation: Situation,
        /// `download of 1 byte to 1000h:00`.
        stimulus: String,
    },
    /// One that only its case knows: what has to happen then, in one sentence.
    Own(Cow<'static, str>),
}

/// What would have been right.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Allowed {
    /// One of these; the best answer first.
    OneOf(Vec<Observation>),
    /// A time between these.
    Time {
        /// The shortest.
        least: Duration,
        /// The longest.
        most: Duration,
    },
    /// As many between these.
    Count {
        /// The fewest.
        least: u64,
        /// The most; `None`: no limit.
        most: Option<u64>,
    },
    /// What can only be described.
    Described(Cow<'static, str>),
}

/// What a check found: nothing wrong, or a breach. `?` ends the case with the breach;
/// [`Bench::check`](crate::bench::Bench::check) records it and lets the case go on.
pub type Check = Result<(), Box<Breach>>;

impl Breach {
    /// A breach in a situation that only its case knows: `duty` says what has to happen, in one sentence.
    pub fn new(subject: impl Into<Subject>, duty: impl Into<Cow<'static, str>>) -> Self {
        Self {
            subject: subject.into(),
            situation: When::Own(duty.into()),
            allowed: Allowed::Described(Cow::Borrowed("what the standard says")),
            actual: Observation::Silence,
            detail: None,
            grade: Grade::Wrong,
            seen: None,
            periods: 1,
        }
    }

    /// A breach in a situation of the table of allowed answers: `stimulus` says what was sent.
    pub fn listed(subject: impl Into<Subject>, situation: Situation, stimulus: impl Into<String>) -> Self {
        let allowed = Allowed::OneOf(situation.allowed().to_vec());
        let situation = When::Listed { situation, stimulus: stimulus.into() };
        Self { situation, allowed, ..Self::new(subject, "") }
    }

    /// What would have been right.
    #[must_use]
    pub fn expected(self, allowed: impl Into<Allowed>) -> Self {
        Self { allowed: allowed.into(), ..self }
    }

    /// What came instead.
    #[must_use]
    pub fn found(self, actual: Observation) -> Self {
        Self { actual, ..self }
    }

    /// What came, in more words.
    #[must_use]
    pub fn told(self, detail: impl Into<String>) -> Self {
        Self { detail: Some(detail.into()), ..self }
    }

    /// The time that was found is the mean of this many periods.
    #[must_use]
    pub fn over(self, periods: u64) -> Self {
        Self { periods: periods.max(1), ..self }
    }

    /// Accepted by CiA's own test tool.
    #[must_use]
    pub fn tolerated(self) -> Self {
        Self { grade: Grade::Tolerated, ..self }
    }

    /// Left open by the standard.
    #[must_use]
    pub fn open(self) -> Self {
        Self { grade: Grade::Open, ..self }
    }

    /// Whether a tester's machine that was late may have made it: it rests on a time, or on what did not come in time.
    pub fn depends_on_time(&self) -> bool {
        self.actual.depends_on_time() || matches!(self.allowed, Allowed::Time { .. })
    }

    /// Whether a time was measured, or had to be.
    pub fn is_of_a_time(&self) -> bool {
        matches!(self.actual, Observation::Time(_)) || matches!(self.allowed, Allowed::Time { .. })
    }

    /// By how much a time is outside of what is allowed, over all its periods; `None` if it is not, or is no time.
    pub fn outside(&self) -> Option<Duration> {
        let (Allowed::Time { least, most }, Observation::Time(time)) = (&self.allowed, &self.actual) else {
            return None;
        };
        let outside = least.0.saturating_sub(time.0).max(time.0.saturating_sub(most.0));
        (outside > 0).then(|| Duration(outside).times(self.periods))
    }

    /// Whether it is a time that is outside of what is allowed, by no more than that over all its periods.
    pub fn is_outside_by(&self, at_most: Duration) -> bool {
        self.outside().is_some_and(|outside| outside <= at_most)
    }

    /// What has to happen, in one sentence.
    pub fn duty(&self) -> String {
        match &self.situation {
            When::Listed { situation, stimulus } => format!("{}: {stimulus}", situation.requirement()),
            When::Own(duty) => duty.clone().into_owned(),
        }
    }

    /// What came, as people read it.
    pub fn found_text(&self) -> String {
        self.detail.clone().unwrap_or_else(|| described(&self.actual))
    }
}

/// An observation as people read it: an abort code with its meaning.
fn described(observation: &Observation) -> String {
    match observation {
        Observation::Abort(code) => format!("abort {code}"),
        Observation::Silence => "no answer".to_owned(),
        Observation::State(state) => state.to_string(),
        Observation::Time(span) => span.to_string(),
        Observation::Count(count) => count.to_string(),
        Observation::Value(bytes) => canvass_bus::client::sdo::Bytes(bytes).to_string(),
        Observation::Violation(violation) => violation.to_string(),
        Observation::Emcy(code) => format!("EMCY {code}"),
        other => other.to_string(),
    }
}

/// What a transfer led to, as an observation.
pub fn observed(outcome: &Outcome) -> Observation {
    match outcome {
        Outcome::Uploaded(value) => Observation::Value(value.clone()),
        Outcome::Downloaded => Observation::Confirmation,
        Outcome::Aborted(abort) => Observation::Abort(abort.code),
        Outcome::Silent => Observation::Silence,
        Outcome::Violated(violation) => Observation::Violation(violation.clone()),
        Outcome::Exceeded(_) => Observation::Violation(canvass_bus::client::Violation::Endless),
    }
}

/// What a response is, as an observation; one out of place is a violation.
pub fn observed_response(response: &canvass_analyzer::wire::sdo::Response) -> Observation {
    use canvass_analyzer::wire::sdo::Response;
    match response {
        Response::Abort(abort) => Observation::Abort(abort.code),
        other => Observation::named(name(other)),
    }
}

impl From<Observation> for Allowed {
    fn from(observation: Observation) -> Self {
        Self::OneOf(vec![observation])
    }
}

impl From<&'static str> for Allowed {
    fn from(text: &'static str) -> Self {
        Self::Described(Cow::Borrowed(text))
    }
}

impl From<String> for Allowed {
    fn from(text: String) -> Self {
        Self::Described(Cow::Owned(text))
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OneOf(observations) => {
                for (n, observation) in observations.iter().enumerate() {
                    write!(f, "{}{}", if n == 0 { "" } else { " or " }, described(observation))?;
                }
                Ok(())
            }
            Self::Time { least, most } => write!(f, "{least} to {most}"),
            Self::Count { least, most: Some(most) } if least == most => write!(f, "{least}"),
            Self::Count { least, most: Some(most) } => write!(f, "{least} to {most}"),
            Self::Count { least, most: None } => write!(f, "at least {least}"),
            Self::Described(text) => f.write_str(text),
        }
    }
}

/// `DUTY: expected EXPECTED, found ACTUAL`.
impl fmt::Display for Breach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: expected {}, found {}", self.duty(), self.allowed, self.found_text())
    }
}

impl From<&Breach> for Reason {
    fn from(breach: &Breach) -> Self {
        Self::new(breach.duty(), breach.allowed.to_string(), breach.found_text())
    }
}
