//! What a transfer or a single message to the SDO server led to, judged by what it had to lead to.

use crate::situation::{Judgement, Situation};
use crate::verdict::{Breach, Check, demand, observed, observed_response};
use canvass_analyzer::wire::sdo::{AbortCode, Request, Response};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::sdo::{Bytes, Outcome, name};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Frame;

/// A transfer that was tried, and how it ended.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// The object of the transfer.
    pub multiplexer: Multiplexer,
    /// `download of 1 byte to 1000h:00`.
    pub what: String,
    /// How it ended.
    pub outcome: Outcome,
    /// The server's frames as they came.
    pub responses: Vec<Frame>,
}

/// One message to the server and the one that came back, if any.
#[derive(Clone, Debug)]
pub struct Reply {
    /// The object that was asked for, where the message names one; else the service.
    pub subject: Subject,
    /// What was sent, in words.
    pub what: String,
    /// What came.
    pub response: Option<Response>,
    /// The frame that carried it.
    pub frame: Option<Frame>,
}

impl Attempt {
    /// The same, told with what the case did before or meanwhile: `in the middle of a download`.
    #[must_use]
    pub fn under(mut self, circumstance: &str) -> Self {
        self.what = format!("{} {circumstance}", self.what);
        self
    }

    /// Whether no response came.
    pub const fn is_silent(&self) -> bool {
        matches!(self.outcome, Outcome::Silent)
    }

    /// The abort code, if the server aborted.
    pub const fn abort(&self) -> Option<AbortCode> {
        match &self.outcome {
            Outcome::Aborted(abort) => Some(abort.code),
            _ => None,
        }
    }

    /// The value that was read.
    ///
    /// # Errors
    /// The breach if there is none.
    pub fn value(self) -> Result<Vec<u8>, Box<Breach>> {
        match self.outcome {
            Outcome::Uploaded(value) => Ok(value),
            ref other => {
                let breach = Breach::new(self.multiplexer, format!("the {} is answered", self.what));
                Err(Box::new(breach.expected("the value").found(observed(other)).told(other.to_string())))
            }
        }
    }

    /// Demands that the server took all that was written.
    ///
    /// # Errors
    /// The breach if it did not.
    pub fn expect_confirmation(&self) -> Check {
        self.judged(Situation::Confirmed)
    }

    /// Demands the refusal that the standard allows in a situation.
    ///
    /// # Errors
    /// The breach for everything else.
    pub fn refused(&self, situation: Situation) -> Check {
        self.judged(situation)
    }

    fn judged(&self, situation: Situation) -> Check {
        judge(self.multiplexer.into(), situation, &self.what, observed(&self.outcome), || self.outcome.to_string())
    }
}

impl Reply {
    /// What came, in words.
    pub fn actual(&self) -> String {
        match (&self.response, &self.frame) {
            (Some(Response::Abort(abort)), _) => format!("abort {}", abort.code),
            (Some(response), Some(frame)) => format!("{} ({})", name(response), Bytes(frame.data())),
            (_, Some(frame)) => format!("an unreadable response ({})", Bytes(frame.data())),
            (_, None) => "no answer".to_owned(),
        }
    }

    /// What came.
    pub fn observation(&self) -> Observation {
        match (&self.response, &self.frame) {
            (Some(response), _) => observed_response(response),
            (None, Some(frame)) => Observation::Frame(*frame),
            (None, None) => Observation::Silence,
        }
    }

    /// The abort code, if the server aborted.
    pub const fn abort(&self) -> Option<AbortCode> {
        match &self.response {
            Some(Response::Abort(abort)) => Some(abort.code),
            _ => None,
        }
    }

    /// Demands the refusal that the standard allows in a situation.
    ///
    /// # Errors
    /// The breach for everything else.
    pub fn refused(&self, situation: Situation) -> Check {
        judge(self.subject, situation, &self.what, self.observation(), || self.actual())
    }

    /// Demands that nothing came.
    ///
    /// # Errors
    /// The breach if something did.
    pub fn expect_silence(&self) -> Check {
        self.refused(Situation::Unanswered)
    }

    /// Demands a response that `right` recognises.
    ///
    /// # Errors
    /// The breach for everything else.
    pub fn expect(&self, expected: &'static str, right: impl FnOnce(&Response) -> bool) -> Check {
        demand(self.response.as_ref().is_some_and(right), || {
            let breach = Breach::new(self.subject, format!("the {} is answered", self.what));
            breach.expected(expected).found(self.observation()).told(self.actual())
        })
    }
}

/// What a message is about.
pub(super) fn subject_of(request: &Request) -> Subject {
    request.multiplexer().map_or(Subject::Service(Service::Sdo), Subject::Entry)
}

/// Holds an answer against the table of what is allowed.
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
