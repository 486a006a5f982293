//! SDO transfers and single SDO messages, each judged by what it had to lead to.

use super::Bench;
use crate::verdict::{Judged, Reason, Verdict, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, AbortCode, Request, Response};
use canvass_bus::client::sdo::{Bytes, Mode, Outcome, Step, Transfer, Violation, name};
use canvass_traces::{Duration, Frame};

/// A transfer that was tried, and how it ended.
#[derive(Clone, Debug)]
pub struct Attempt {
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
    /// [`Verdict::Error`] if the bus fails, [`Verdict::Inconclusive`] if the run was cancelled.
    pub fn upload(&mut self, multiplexer: Multiplexer) -> Result<Attempt, Verdict> {
        let (transfer, request) = Transfer::upload(multiplexer);
        self.transfer(transfer, request, format!("upload of {multiplexer}"))
    }

    /// Writes an object, in the shortest way. Its value before is put back after the case.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn download(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<Attempt, Verdict> {
        self.remember(multiplexer)?;
        self.download_as(multiplexer, value, Mode::Shortest)
    }

    /// Writes an object in segments, even where it is short. Its value before is put back after the case.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn download_segmented(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<Attempt, Verdict> {
        self.remember(multiplexer)?;
        self.download_as(multiplexer, value, Mode::Segmented)
    }

    pub(super) fn download_as(
        &mut self,
        multiplexer: Multiplexer,
        value: &[u8],
        mode: Mode,
    ) -> Result<Attempt, Verdict> {
        let (transfer, request) = Transfer::download(multiplexer, value, mode);
        let plural = if value.len() == 1 { "" } else { "s" };
        let how = if mode == Mode::Segmented { "segmented download" } else { "download" };
        self.transfer(transfer, request, format!("{how} of {} byte{plural} to {multiplexer}", value.len()))
    }

    /// Reads a value that the case needs but is not about.
    ///
    /// # Errors
    /// [`Verdict::Inconclusive`] if the device does not give it.
    pub fn read(&mut self, multiplexer: Multiplexer) -> Result<Vec<u8>, Verdict> {
        self.upload(multiplexer)?.value().map_err(Verdict::as_inconclusive)
    }

    /// Reads a number of up to four bytes that the case needs but is not about.
    ///
    /// # Errors
    /// [`Verdict::Inconclusive`] if the device does not give it.
    pub fn read_number(&mut self, multiplexer: Multiplexer) -> Result<u32, Verdict> {
        let value = self.read(multiplexer)?;
        Ok(number(&value))
    }

    /// Writes a value that the case needs but is not about.
    ///
    /// # Errors
    /// [`Verdict::Inconclusive`] if the device refuses it.
    pub fn write(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<(), Verdict> {
        self.download(multiplexer, value)?.expect_confirmation().map(|_| ()).map_err(Verdict::as_inconclusive)
    }

    /// Sends one SDO message, in or out of place, and waits for one response.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn exchange(&mut self, request: &Request, what: impl Into<String>) -> Result<Reply, Verdict> {
        self.drain()?;
        self.send_request(request)?;
        let frame = self.wait_for_response(self.timing().sdo_response)?;
        let response = frame.and_then(|frame| Response::read(frame.data()).ok());
        Ok(Reply { what: what.into(), response, frame })
    }

    /// Sends one SDO message that must not be answered, and waits as long as silence takes.
    ///
    /// # Errors
    /// As [`Bench::upload`].
    pub fn send_unanswered(&mut self, request: &Request, what: impl Into<String>) -> Result<Reply, Verdict> {
        self.drain()?;
        self.send_request(request)?;
        let frame = self.wait_for_response(self.timing().silence)?;
        let response = frame.and_then(|frame| Response::read(frame.data()).ok());
        Ok(Reply { what: what.into(), response, frame })
    }

    /// Reads an object again and demands that it still has the value of before.
    ///
    /// # Errors
    /// [`Verdict::Fail`] if it has another.
    pub fn expect_unchanged(&mut self, multiplexer: Multiplexer, before: &[u8]) -> Judged {
        let now = self.read(multiplexer)?;
        demand(now == before, || {
            let duty = format!("{multiplexer} keeps its value after the refusal");
            Reason::new(duty, Bytes(before).to_string(), Bytes(&now).to_string())
        })
    }

    fn transfer(&mut self, mut transfer: Transfer, first: Request, what: String) -> Result<Attempt, Verdict> {
        self.drain()?;
        let stores = first.multiplexer().is_some_and(|object| matches!(object.index.0, 0x1010 | 0x1011));
        let patience = if stores { self.timing().store } else { self.timing().sdo_response };
        let mut request = first;
        let mut responses = Vec::new();
        loop {
            self.send_request(&request)?;
            let Some(frame) = self.wait_for_response(patience)? else {
                self.send_request(&transfer.abort(AbortCode::TIMEOUT))?;
                return Ok(Attempt { what, outcome: Outcome::Silent, responses });
            };
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
                    return Ok(Attempt { what, outcome, responses });
                }
            }
        }
    }

    /// Sends one SDO message and does not wait.
    ///
    /// # Errors
    /// As [`Bench::send`].
    pub fn send_request(&mut self, request: &Request) -> Result<(), Verdict> {
        let cob_id = sdo::REQUEST_BASE + u16::from(self.node().raw());
        self.send(&request.to_frame(cob_id)).map(|_| ())
    }

    pub(super) fn wait_for_response(&mut self, span: Duration) -> Result<Option<Frame>, Verdict> {
        let cob_id = sdo::RESPONSE_BASE + u16::from(self.node().raw());
        self.wait_for(span, |record| (record.frame.cob_id() == Some(cob_id)).then_some(record.frame))
    }
}

impl Attempt {
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
    /// [`Verdict::Fail`] if there is none.
    pub fn value(self) -> Result<Vec<u8>, Verdict> {
        match self.outcome {
            Outcome::Uploaded(value) => Ok(value),
            other => Err(Verdict::Fail(Reason::new(
                format!("the {} is answered", self.what),
                "the value",
                other.to_string(),
            ))),
        }
    }

    /// Demands that the server took all that was written.
    ///
    /// # Errors
    /// [`Verdict::Fail`] if it did not.
    pub fn expect_confirmation(&self) -> Judged {
        demand(self.outcome == Outcome::Downloaded, || {
            Reason::new(format!("the {} is confirmed", self.what), "confirmation", self.outcome.to_string())
        })
    }

    /// Demands an abort: one of the `strict` codes, which CiA 301 gives for this reason, passes; one that CiA's test
    /// tool also accepts is tolerated.
    ///
    /// # Errors
    /// [`Verdict::Fail`] for everything else.
    pub fn expect_abort(&self, strict: &[AbortCode], tolerated: &[AbortCode]) -> Judged {
        judge_abort(&self.what, self.abort(), &self.outcome.to_string(), strict, tolerated)
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

    /// The abort code, if the server aborted.
    pub const fn abort(&self) -> Option<AbortCode> {
        match &self.response {
            Some(Response::Abort(abort)) => Some(abort.code),
            _ => None,
        }
    }

    /// Demands an abort, as [`Attempt::expect_abort`].
    ///
    /// # Errors
    /// [`Verdict::Fail`] for everything else.
    pub fn expect_abort(&self, strict: &[AbortCode], tolerated: &[AbortCode]) -> Judged {
        judge_abort(&self.what, self.abort(), &self.actual(), strict, tolerated)
    }

    /// Demands that nothing came.
    ///
    /// # Errors
    /// [`Verdict::Fail`] if something did.
    pub fn expect_silence(&self) -> Judged {
        demand(self.frame.is_none(), || {
            Reason::new(format!("the {} is not answered", self.what), "silence", self.actual())
        })
    }

    /// Demands a response that `right` recognises.
    ///
    /// # Errors
    /// [`Verdict::Fail`] for everything else.
    pub fn expect(&self, expected: &str, right: impl FnOnce(&Response) -> bool) -> Judged {
        demand(self.response.as_ref().is_some_and(right), || {
            Reason::new(format!("the {} is answered", self.what), expected, self.actual())
        })
    }
}

fn judge_abort(
    what: &str,
    found: Option<AbortCode>,
    actual: &str,
    strict: &[AbortCode],
    tolerated: &[AbortCode],
) -> Judged {
    let codes: Vec<String> = strict.iter().map(ToString::to_string).collect();
    let reason = || Reason::new(format!("the {what} is refused"), format!("abort {}", codes.join(" or ")), actual);
    match found {
        Some(code) if strict.contains(&code) => Ok(Verdict::Pass),
        Some(code) if tolerated.contains(&code) => Ok(Verdict::Tolerated(reason())),
        _ => Err(Verdict::Fail(reason())),
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

    const DEVICE_TYPE: Multiplexer = Multiplexer::new(0x1000, 0);

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
                attempt.expect_abort(&[AbortCode::NO_OBJECT], &[AbortCode::GENERAL])
            })
        };
        assert_eq!(judged(&[("63F#4000100000000000", "5BF#8000100000000206")]), Ok(Verdict::Pass));
        assert!(matches!(judged(&[("63F#4000100000000000", "5BF#8000100000000008")]), Ok(Verdict::Tolerated(_))));
        let Err(Verdict::Fail(reason)) = judged(&[("63F#4000100000000000", "5BF#8000100011000906")]) else { panic!() };
        assert_eq!(reason.expected, "abort 0602 0000h object does not exist in the object dictionary");
        assert_eq!(reason.actual, "abort 0609 0011h sub-index does not exist");
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
