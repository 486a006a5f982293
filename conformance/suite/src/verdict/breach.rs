//! Breaches: differences that a check found.

use super::Reason;
use crate::situation::Situation;
use canvass_bus::client::sdo::{Outcome, name};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Timestamp};
use std::borrow::Cow;
use std::fmt;

/// A difference that a check found: its subject, its time, the allowed behaviour, and the actual one.
///
/// Sheets of manuals and waivers are compared with [`Breach::subject`] and [`Breach::actual`]; the words are only for
/// people.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Breach {
    /// The part of the device with the breach.
    pub subject: Subject,
    /// The request to the device, or the event before the breach.
    pub situation: When,
    /// The allowed behaviour.
    pub allowed: Allowed,
    /// The actual behaviour.
    pub actual: Observation,
    /// The actual behaviour with more details than the observation has: the other values, the frame.
    pub detail: Option<String>,
    /// The severity of the breach.
    pub grade: Grade,
    /// The time of the breach on the clock of the bus.
    pub seen: Option<Timestamp>,
    /// Number of periods of which a time is the mean; 1 for a single period.
    pub periods: u64,
    /// The lateness of a device without processor time that would explain the breach, if it is known.
    pub lateness: Option<Duration>,
    /// Whether the breach follows from values that the device measured at different times, so that a change of the
    /// measured quantity between them would explain it.
    pub compares_measurements: bool,
}

/// The severity of a breach.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Grade {
    /// The standard leaves the behaviour open: the breach is recorded.
    Open,
    /// The behaviour violates the standard, but CiA's own test tool accepts it.
    Tolerated,
    /// The behaviour violates the standard.
    Wrong,
}

/// The situation of a breach.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum When {
    /// A row of the table of allowed answers, with the exact request.
    Listed {
        /// The row.
        situation: Situation,
        /// The request in words: `download of 1 byte to 1000h:00`.
        stimulus: String,
    },
    /// A situation that only its case knows: the required behaviour in one sentence.
    Own(Cow<'static, str>),
}

/// The allowed behaviour.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Allowed {
    /// One of these observations; the best comes first.
    OneOf(Vec<Observation>),
    /// A time within limits.
    Time {
        /// The shortest time.
        least: Duration,
        /// The longest time.
        most: Duration,
    },
    /// A number within limits.
    Count {
        /// The minimum.
        least: u64,
        /// The maximum; `None` means no limit.
        most: Option<u64>,
    },
    /// A behaviour that can only be described.
    Described(Cow<'static, str>),
}

/// The result of a check: success, or a breach. `?` ends the case with the breach;
/// [`Bench::check`](crate::bench::Bench::check) records it and lets the case go on.
pub type Check = Result<(), Box<Breach>>;

impl Breach {
    /// A breach in a situation that only its case knows: `duty` is the required behaviour in one sentence.
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
            lateness: None,
            compares_measurements: false,
        }
    }

    /// A breach in a situation of the table of allowed answers: `stimulus` describes the request.
    pub fn listed(subject: impl Into<Subject>, situation: Situation, stimulus: impl Into<String>) -> Self {
        let allowed = Allowed::OneOf(situation.allowed().to_vec());
        let situation = When::Listed { situation, stimulus: stimulus.into() };
        Self { situation, allowed, ..Self::new(subject, "") }
    }

    /// Sets the allowed behaviour.
    #[must_use]
    pub fn expected(self, allowed: impl Into<Allowed>) -> Self {
        Self { allowed: allowed.into(), ..self }
    }

    /// Sets the actual behaviour.
    #[must_use]
    pub fn found(self, actual: Observation) -> Self {
        Self { actual, ..self }
    }

    /// Adds details to the actual behaviour.
    #[must_use]
    pub fn told(self, detail: impl Into<String>) -> Self {
        Self { detail: Some(detail.into()), ..self }
    }

    /// Declares that the measured time is the mean of this many periods.
    #[must_use]
    pub fn over(self, periods: u64) -> Self {
        Self { periods: periods.max(1), ..self }
    }

    /// Declares the lateness of a device without processor time that would explain the breach.
    #[must_use]
    pub fn explained_by(self, lateness: Duration) -> Self {
        Self { lateness: Some(lateness), ..self }
    }

    /// Declares that a change of the measured quantity during the case would explain the breach.
    #[must_use]
    pub fn explained_by_motion(self) -> Self {
        Self { compares_measurements: true, ..self }
    }

    /// Marks the breach as accepted by CiA's own test tool.
    #[must_use]
    pub fn tolerated(self) -> Self {
        Self { grade: Grade::Tolerated, ..self }
    }

    /// Marks the breach as left open by the standard.
    #[must_use]
    pub fn open(self) -> Self {
        Self { grade: Grade::Open, ..self }
    }

    /// Whether a late machine of the tester may have caused the breach: it depends on a time, or on a missing message.
    pub fn depends_on_time(&self) -> bool {
        self.actual.depends_on_time() || matches!(self.allowed, Allowed::Time { .. })
    }

    /// Whether a time was measured or required.
    pub(crate) fn is_of_a_time(&self) -> bool {
        matches!(self.actual, Observation::Time(_)) || matches!(self.allowed, Allowed::Time { .. })
    }

    /// The distance of a time from its limits, over all its periods; `None` if it is within them, or is no time.
    pub fn outside(&self) -> Option<Duration> {
        let (Allowed::Time { least, most }, Observation::Time(time)) = (&self.allowed, &self.actual) else {
            return None;
        };
        let outside = least.0.saturating_sub(time.0).max(time.0.saturating_sub(most.0));
        (outside > 0).then(|| Duration(outside).times(self.periods))
    }

    /// Whether a time is outside its limits by at most `at_most` over all its periods.
    pub fn is_outside_by(&self, at_most: Duration) -> bool {
        self.outside().is_some_and(|outside| outside <= at_most)
    }

    /// The row of the table of allowed answers, if the situation is one of it.
    pub const fn row(&self) -> Option<Situation> {
        match self.situation {
            When::Listed { situation, .. } => Some(situation),
            When::Own(_) => None,
        }
    }

    /// The required behaviour in one sentence.
    pub fn duty(&self) -> String {
        match &self.situation {
            When::Listed { situation, stimulus } => format!("{}: {stimulus}", situation.requirement()),
            When::Own(duty) => duty.clone().into_owned(),
        }
    }

    /// The actual behaviour in words.
    pub fn found_text(&self) -> String {
        self.detail.clone().unwrap_or_else(|| described(&self.actual))
    }
}

/// An observation in words: an abort code includes its meaning.
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

/// The outcome of a transfer as an observation.
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

/// A response as an observation. An unexpected response is a violation.
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
