//! SDO transfers and single SDO messages, each judged by what it had to lead to.

use super::Bench;
use super::block::ABORT;
use crate::situation::{Judgement, Situation};
use crate::verdict::{Breach, Check, Judged, Precondition, Stop, demand, observed, observed_response};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, AbortCode, Request, Response};
use canvass_analyzer::{Multiplexer, Service};
use canvass_bus::client::sdo::{Bytes, Mode, Outcome, Step, Transfer, Violation, name};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::{Duration, Frame};
use std::borrow::Cow;

/// An object that every device has.
pub const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);

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

impl Bench<'_> {
    /// Reads an object.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus fails, [`Stop::Inconclusive`] if the run was cancelled.
    pub fn upload(&mut self, multiplexer: Multiplexer) -> Result<Attempt, Stop> {
        let (transfer, request) = Transfer::upload(multiplexer);
        self.transfer(transfer, request, format!("upload of {multiplexer}"))
    }

    /// Writes an object, in the shortest way. Its value before is put back after the case.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn download(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<Attempt, Stop> {
        self.remember(multiplexer)?;
        self.download_as(multiplexer, value, Mode::Shortest)
    }

    /// Writes an object in segments, even where it is short. Its value before is put back after the case.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn download_segmented(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<Attempt, Stop> {
        self.remember(multiplexer)?;
        self.download_as(multiplexer, value, Mode::Segmented)
    }

    pub(super) fn download_as(&mut self, multiplexer: Multiplexer, value: &[u8], mode: Mode) -> Result<Attempt, Stop> {
        let (transfer, request) = Transfer::download(multiplexer, value, mode);
        let plural = if value.len() == 1 { "" } else { "s" };
        let how = if mode == Mode::Segmented { "segmented download" } else { "download" };
        self.transfer(transfer, request, format!("{how} of {} byte{plural} to {multiplexer}", value.len()))
    }

    /// Reads a value that the case needs but is not about.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device does not give it.
    pub fn read(&mut self, multiplexer: Multiplexer) -> Result<Vec<u8>, Stop> {
        self.upload(multiplexer)?.value().or_inconclusive()
    }

    /// Reads a number of up to four bytes that the case needs but is not about.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device does not give it.
    pub fn read_number(&mut self, multiplexer: Multiplexer) -> Result<u32, Stop> {
        let value = self.read(multiplexer)?;
        Ok(number(&value))
    }

    /// Writes a value that the case needs but is not about.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses it.
    pub fn write(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<(), Stop> {
        self.download(multiplexer, value)?.expect_confirmation().or_inconclusive()
    }

    /// Sends one SDO message, in or out of place, and waits for one response.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn exchange(&mut self, request: &Request, what: impl Into<String>) -> Result<Reply, Stop> {
        self.exchange_within(request, what.into(), self.timing().sdo_response)
    }

    /// Sends one SDO message that must not be answered, and waits as long as silence takes.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn send_unanswered(&mut self, request: &Request, what: impl Into<String>) -> Result<Reply, Stop> {
        self.exchange_within(request, what.into(), self.timing().silence)
    }

    fn exchange_within(&mut self, request: &Request, what: String, span: Duration) -> Result<Reply, Stop> {
        self.drain()?;
        self.send_request(request)?;
        let frame = self.wait_for_response(span)?;
        // After these a segment of a block may follow, which has no command specifier.
        let is_block = matches!(request, Request::StartBlockUpload | Request::ConfirmBlockUpload { .. });
        if let Some(frame) = frame.filter(|frame| !is_block || frame.bytes()[0] == ABORT) {
            self.judge_answer(request.multiplexer(), &frame);
        }
        let response = frame.and_then(|frame| Response::read(frame.data()).ok());
        Ok(Reply { subject: subject_of(request), what, response, frame })
    }

    /// Reads an object and demands that value; `duty` says why it has to have it.
    ///
    /// # Errors
    /// A breach if it can't be read.
    pub fn expect_value(
        &mut self,
        multiplexer: Multiplexer,
        right: &[u8],
        duty: impl Into<Cow<'static, str>>,
    ) -> Judged {
        let now = self.upload(multiplexer)?.value()?;
        self.check(demand(now == right, || {
            let breach = Breach::new(multiplexer, duty).expected(Observation::Value(right.to_vec()));
            breach.found(Observation::Value(now))
        }))
    }

    /// A response that comes though nothing was asked since.
    ///
    /// # Errors
    /// As [`Bench::wait_for`].
    pub fn wait_for_late_response(&mut self) -> Result<Option<Frame>, Stop> {
        self.wait_for_response(self.timing().silence)
    }

    /// Reads an object again and demands that it still has the value of before.
    ///
    /// # Errors
    /// A breach if it can't be read any more.
    pub fn expect_unchanged(&mut self, multiplexer: Multiplexer, before: &[u8]) -> Judged {
        self.expect_value(multiplexer, before, format!("{multiplexer} keeps its value"))
    }

    /// Demands that the server serves a right request, after what the case did to it.
    ///
    /// # Errors
    /// A breach if it does not.
    pub fn expect_served(&mut self, circumstance: &str) -> Judged {
        self.upload(DEVICE_TYPE)?.under(circumstance).value()?;
        Ok(())
    }

    fn transfer(&mut self, mut transfer: Transfer, first: Request, what: String) -> Result<Attempt, Stop> {
        self.drain()?;
        let stores = first.multiplexer().is_some_and(|object| matches!(object.index.0, 0x1010 | 0x1011));
        let patience = if stores { self.timing().store } else { self.timing().sdo_response };
        let multiplexer = transfer.multiplexer();
        let mut request = first;
        let mut responses = Vec::new();
        loop {
            self.send_request(&request)?;
            let Some(frame) = self.wait_for_response(patience)? else {
                self.send_request(&transfer.abort(AbortCode::TIMEOUT))?;
                return Ok(Attempt { multiplexer, what, outcome: Outcome::Silent, responses });
            };
            self.judge_answer(Some(multiplexer), &frame);
            // Of a long upload the first frames tell enough of their form.
            if responses.len() < 256 {
                responses.push(frame);
            }
            let step = match Response::read(frame.data()) {
                Ok(response) => transfer.handle(&response),
                Err(error) => Step::Done(Outcome::Violated(Violation::Malformed(error.to_string()))),
            };
            match step {
                Step::Send(next) => request = next,
                Step::Done(outcome) => {
                    if matches!(outcome, Outcome::Violated(_)) {
                        self.send_request(&transfer.abort(AbortCode::GENERAL))?;
                    }
                    return Ok(Attempt { multiplexer, what, outcome, responses });
                }
            }
        }
    }

    /// Sends one SDO message and does not wait.
    ///
    /// # Errors
    /// As [`Bench::send`].
    pub fn send_request(&mut self, request: &Request) -> Result<(), Stop> {
        let cob_id = sdo::REQUEST_BASE + u16::from(self.node().raw());
        self.send(&request.to_frame(cob_id)).map(|_| ())
    }

    pub(super) fn wait_for_response(&mut self, span: Duration) -> Result<Option<Frame>, Stop> {
        let cob_id = sdo::RESPONSE_BASE + u16::from(self.node().raw());
        self.wait_for(span, |record| (record.frame.cob_id() == Some(cob_id)).then_some(record.frame))
    }
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

    pub fn refused_with(&self, strict: &[AbortCode], tolerated: &[AbortCode]) -> Check {
        judge_codes(
            self.multiplexer.into(),
            &self.what,
            observed(&self.outcome),
            self.outcome.to_string(),
            strict,
            tolerated,
        )
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

    pub fn refused_with(&self, strict: &[AbortCode], tolerated: &[AbortCode]) -> Check {
        judge_codes(self.subject, &self.what, self.observation(), self.actual(), strict, tolerated)
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
fn subject_of(request: &Request) -> Subject {
    request.multiplexer().map_or(Subject::Service(Service::Sdo), Subject::Entry)
}

fn judge_codes(
    subject: Subject,
    what: &str,
    found: Observation,
    told: String,
    strict: &[AbortCode],
    tolerated: &[AbortCode],
) -> Check {
    let allowed = crate::verdict::Allowed::OneOf(strict.iter().copied().map(Observation::Abort).collect());
    let breach =
        Breach::new(subject, format!("the {what} is refused")).expected(allowed).found(found.clone()).told(told);
    match found {
        Observation::Abort(code) if strict.contains(&code) => Ok(()),
        Observation::Abort(code) if tolerated.contains(&code) => Err(Box::new(breach.tolerated())),
        _ => Err(Box::new(breach)),
    }
}

/// Holds an answer against the table of what is allowed.
fn judge(
    subject: Subject,
    situation: Situation,
    what: &str,
    found: Observation,
    told: impl FnOnce() -> String,
) -> Check {
    let breach = || Breach::listed(subject, situation, what).found(found.clone()).told(told());
    match situation.judge(&found) {
        Judgement::Allowed => Ok(()),
        Judgement::Tolerated => Err(Box::new(breach().tolerated())),
        Judgement::Wrong => Err(Box::new(breach())),
    }
}

/// The first four bytes as a little-endian number.
pub fn number(value: &[u8]) -> u32 {
    value.iter().take(4).rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::{frame, table, with_bench};
    use crate::verdict::Grade;

    /// Background traffic of this and of other nodes does not disturb a transfer.
    #[test]
    fn other_traffic_goes_by() {
        let script = |request: &Frame| {
            let answers =
                ["73F#7F", "1BF#0102", "5BE#4000100000000000", "0BF#0010010000000000", "5BF#4300100096010200"];
            let is_request = request.to_string() == "63F#4000100000000000";
            let answers: Vec<_> = answers.iter().map(|answer| (Duration::from_millis(1), frame(answer))).collect();
            if is_request { answers } else { Vec::new() }
        };
        let value = with_bench(script, |bench| bench.upload(DEVICE_TYPE).unwrap().value().unwrap());
        assert_eq!(value, [0x96, 0x01, 0x02, 0x00]);
    }

    #[test]
    fn an_answer_that_comes_too_late_is_not_taken_for_the_next() {
        let mut asked = 0;
        let script = move |request: &Frame| {
            if !request.to_string().starts_with("63F#40") {
                return Vec::new();
            }
            asked += 1;
            let (delay, answer) =
                if asked == 1 { (1_500, "5BF#4300100001000000") } else { (1, "5BF#4300100002000000") };
            vec![(Duration::from_millis(delay), frame(answer))]
        };
        with_bench(script, |bench| {
            assert!(bench.upload(DEVICE_TYPE).unwrap().is_silent());
            bench.listen(Duration::from_secs(1)).unwrap();
            assert_eq!(bench.upload(DEVICE_TYPE).unwrap().value().unwrap(), [2, 0, 0, 0]);
        });
    }

    #[test]
    fn abort_codes_are_strict_tolerated_or_wrong() {
        let judged = |answer: &'static [(&'static str, &'static str)]| {
            with_bench(table(answer), |bench| {
                let attempt = bench.upload(DEVICE_TYPE).unwrap();
                attempt.refused(Situation::MissingObject)
            })
        };
        assert_eq!(judged(&[("63F#4000100000000000", "5BF#8000100000000206")]), Ok(()));
        let tolerated = judged(&[("63F#4000100000000000", "5BF#8000100000000008")]).unwrap_err();
        assert_eq!(tolerated.grade, Grade::Tolerated);
        let breach = judged(&[("63F#4000100000000000", "5BF#8000100011000906")]).unwrap_err();
        assert_eq!((breach.grade, breach.subject), (Grade::Wrong, DEVICE_TYPE.into()));
        assert_eq!(breach.actual, Observation::Abort(AbortCode::NO_SUB_INDEX));
        assert_eq!(breach.allowed.to_string(), "abort 0602 0000h object does not exist in the object dictionary");
        assert_eq!(breach.found_text(), "abort 0609 0011h sub-index does not exist");
    }

    /// What a case writes is put back.
    #[test]
    fn values_are_restored() {
        use std::cell::RefCell;
        use std::rc::Rc;
        let time = Rc::new(RefCell::new([0x00, 0x00]));
        let device = Rc::clone(&time);
        let script = move |request: &Frame| {
            let (command, data) = (request.data()[0], request.bytes());
            let mut answer = [0x60, data[1], data[2], data[3], 0, 0, 0, 0];
            match command {
                0x40 => {
                    let [low, high] = *device.borrow();
                    answer = [0x4B, data[1], data[2], data[3], low, high, 0, 0];
                }
                _ => *device.borrow_mut() = [data[4], data[5]],
            }
            vec![(Duration::from_millis(1), Frame::full(canvass_traces::CanId::standard(0x5BF).unwrap(), answer))]
        };
        with_bench(script, |bench| {
            let heartbeat_time = Multiplexer::new(0x1017, 0);
            bench.write(heartbeat_time, &[0xE8, 0x03]).unwrap();
            assert_eq!(*time.borrow(), [0xE8, 0x03]);
            let remains = bench.finish();
            assert!(remains.notes.is_empty() && remains.evidence.frames().count() > 4);
        });
        assert_eq!(*time.borrow(), [0, 0]);
    }
}
