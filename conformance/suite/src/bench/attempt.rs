//! The outcome of a transfer or of a single message to the SDO server, and how it is judged.

use crate::situation::{Judgement, Situation};
use crate::verdict::{Breach, Check, demand, observed, observed_response};
use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::sdo::{Bytes, Outcome, name};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Frame;

/// A transfer that was tried, with its outcome.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The object of the transfer.
    pub multiplexer: Multiplexer,
    /// The transfer in words: `download of 1 byte to 1000h:00`.
    pub what: String,
    /// The outcome of the transfer.
    pub outcome: Outcome,
    /// The server's frames in the order in which they came.
    pub responses: Vec<Frame>,
}

/// One message to the server and its response, if any.
#[derive(Clone, Debug)]
pub struct Reply {
    /// The object that the message names; otherwise the service.
    pub subject: Subject,
    /// The message in words.
    pub what: String,
    /// The decoded response.
    pub response: Option<Response>,
    /// The frame of the response.
    pub frame: Option<Frame>,
}

impl Attempt {
    /// This attempt, with an addition to its words, such as `in the middle of a download`: an action of the case before
    /// or during the transfer.
    #[must_use]
    pub fn under(mut self, circumstance: &str) -> Self {
        self.what = format!("{} {circumstance}", self.what);
        self
    }

    /// Whether no response came.
    pub const fn is_silent(&self) -> bool {
        matches!(self.outcome, Outcome::Silent)
    }

    /// The code of the server's abort; `None` if it did not abort.
    pub const fn abort(&self) -> Option<AbortCode> {
        match &self.outcome {
            Outcome::Aborted(abort) => Some(abort.code),
            _ => None,
        }
    }

    /// The uploaded value.
    ///
    /// # Errors
    /// The breach if the upload gave no value.
    pub fn value(self) -> Result<Vec<u8>, Box<Breach>> {
        match self.outcome {
            Outcome::Uploaded(value) => Ok(value),
            ref other => {
                let breach = Breach::new(self.multiplexer, format!("the {} is answered", self.what));
                Err(Box::new(breach.expected("the value").found(observed(other)).told(other.to_string())))
            }
        }
    }

    /// Requires that the server confirmed the whole download.
    ///
    /// # Errors
    /// The breach if it did not.
    pub(crate) fn expect_confirmation(&self) -> Check {
        self.judged(Situation::Confirmed)
    }

    /// Requires an answer that the table allows in this situation.
    ///
    /// # Errors
    /// The breach if the server answered otherwise.
    pub fn refused(&self, situation: Situation) -> Check {
        self.judged(situation)
    }

    fn judged(&self, situation: Situation) -> Check {
        judge(self.multiplexer.into(), situation, &self.what, observed(&self.outcome), || self.outcome.to_string())
    }
}

impl Reply {
    /// The response in words.
    pub fn actual(&self) -> String {
        match (&self.response, &self.frame) {
            (Some(Response::Abort(abort)), _) => format!("abort {}", abort.code),
            (Some(response), Some(frame)) => format!("{} ({})", name(response), Bytes(frame.data())),
            (_, Some(frame)) => format!("an unreadable response ({})", Bytes(frame.data())),
            (_, None) => "no answer".to_owned(),
        }
    }

    /// The response as an observation.
    pub fn observation(&self) -> Observation {
        match (&self.response, &self.frame) {
            (Some(response), _) => observed_response(response),
            (None, Some(frame)) => Observation::Frame(*frame),
            (None, None) => Observation::Silence,
        }
    }

    /// The code of the server's abort; `None` if it did not abort.
    pub const fn abort(&self) -> Option<AbortCode> {
        match &self.response {
            Some(Response::Abort(abort)) => Some(abort.code),
            _ => None,
        }
    }

    /// Requires an answer that the table allows in this situation.
    ///
    /// # Errors
    /// The breach if the server answered otherwise.
    pub fn refused(&self, situation: Situation) -> Check {
        judge(self.subject, situation, &self.what, self.observation(), || self.actual())
    }

    /// Requires that no response came.
    ///
    /// # Errors
    /// The breach if a response came.
    pub(crate) fn expect_silence(&self) -> Check {
        self.refused(Situation::Unanswered)
    }

    /// Requires a response that `right` recognises.
    ///
    /// # Errors
    /// The breach if the response is another one, or there is none.
    pub fn expect(&self, expected: &'static str, right: impl FnOnce(&Response) -> bool) -> Check {
        demand(self.response.as_ref().is_some_and(right), || {
            let breach = Breach::new(self.subject, format!("the {} is answered", self.what));
            breach.expected(expected).found(self.observation()).told(self.actual())
        })
    }
}

/// The object that a message names; otherwise the service.
pub(super) fn subject_of(request: &Request) -> Subject {
    request.multiplexer().map_or(Subject::Service(Service::Sdo), Subject::Entry)
}

/// Compares an answer with the table of allowed answers.
fn judge(
    subject: Subject,
    situation: Situation,
    what: &str,
    found: Observation,
    told: impl FnOnce() -> String,
) -> Check {
    let judgement = situation.judge(&found);
    let breach = || Breach::listed(subject, situation, what).found(found).told(told());
    match judgement {
        Judgement::Allowed => Ok(()),
        Judgement::Tolerated => Err(Box::new(breach().tolerated())),
        Judgement::Wrong => Err(Box::new(breach())),
    }
}
