//! SDO transfers and single SDO messages, with the judgement of their outcomes.

pub use super::attempt::{Attempt, Reply};

use super::Bench;
use super::attempt::subject_of;
use super::block::ABORT;
use crate::verdict::{Breach, Judged, Precondition, Reason, Stop, demand};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Payload, Request, Response};
use canvass_bus::client::sdo::{Bytes, Mode, Outcome, ServerLine, Transfer};
use canvass_bus::observation::Observation;
use canvass_traces::{Duration, Frame, Timestamp};
use std::borrow::Cow;

/// Number of attempts of a transfer that others disturb.
const TRIES: usize = 3;

/// The device type, which every device has.
pub const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);

impl Bench<'_> {
    /// Reads an object.
    ///
    /// # Errors
    /// [`Stop::Error`] if the bus fails, [`Stop::Inconclusive`] if the run was cancelled.
    pub fn upload(&mut self, multiplexer: Multiplexer) -> Result<Attempt, Stop> {
        let (transfer, request) = Transfer::upload(multiplexer);
        self.transfer(transfer, request, format!("upload of {multiplexer}"))
    }

    /// Writes an object in the shortest way. The bench puts the earlier value back after the case.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn download(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<Attempt, Stop> {
        self.remember(multiplexer)?;
        self.download_as(multiplexer, value, Mode::Shortest)
    }

    /// Writes an object in segments, even if its value is short. The bench puts the earlier value back after the case.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn download_segmented(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<Attempt, Stop> {
        self.remember(multiplexer)?;
        self.download_as(multiplexer, value, Mode::Segmented)
    }

    pub(super) fn download_as(&mut self, multiplexer: Multiplexer, value: &[u8], mode: Mode) -> Result<Attempt, Stop> {
        let (transfer, request) = Transfer::download(multiplexer, value, mode);
        let plural = if value.len() == 1 { "" } else { "s" };
        let how = if mode == Mode::Segmented { "segmented download" } else { "download" };
        self.transfer(transfer, request, format!("{how} of {} byte{plural} to {multiplexer}", value.len()))
    }

    /// Reads a value that the case needs but does not test.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device returns no value, or fewer bytes than the described type has. Extra bytes
    /// are accepted: the response may give no size (CiA 301, 7.2.4.3.6), or the description may be wrong.
    pub fn read(&mut self, multiplexer: Multiplexer) -> Result<Vec<u8>, Stop> {
        let value = self.upload(multiplexer)?.value().or_inconclusive()?;
        match self.described_length(multiplexer) {
            Some(length) if value.len() < length => {
                let duty = format!("{multiplexer} has the length of its data type");
                Err(Stop::Inconclusive(Reason::new(duty, format!("{length} bytes"), Bytes(&value).to_string())))
            }
            _ => Ok(value),
        }
    }

    fn described_length(&self, multiplexer: Multiplexer) -> Option<usize> {
        let description = self.target.description.as_ref()?;
        description.dictionary.entry(multiplexer).ok()?.data_type.bytes()
    }

    /// Reads a number of up to four bytes that the case needs but does not test.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device returns no value.
    pub(crate) fn read_number(&mut self, multiplexer: Multiplexer) -> Result<u32, Stop> {
        let value = self.read(multiplexer)?;
        Ok(number(&value))
    }

    /// Writes a value that the case needs but does not test.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses the value, or confirms it but keeps the earlier value.
    pub fn write(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<(), Stop> {
        self.write_confirmed(multiplexer, value)?;
        self.expect_effect(multiplexer, value)
    }

    /// Writes a value whose effect the case itself judges: the device only has to confirm it.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses the value.
    pub(crate) fn write_confirmed(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<(), Stop> {
        self.download(multiplexer, value)?.expect_confirmation().or_inconclusive()
    }

    /// The number that an object holds; `None` if it can't be read.
    pub(super) fn number_at_last(&mut self, at: Multiplexer) -> Result<Option<u32>, Stop> {
        Ok(self.value_at_last(at)?.map(|value| number(&value)))
    }

    /// The value of an object; `None` if it can't be read. A lost answer is not a lost value, so the object is read
    /// again.
    pub(super) fn value_at_last(&mut self, at: Multiplexer) -> Result<Option<Vec<u8>>, Stop> {
        /// Maximum number of answers that a bad connection loses in a row.
        const ASKED: usize = 3;
        for _ in 0..ASKED {
            match self.upload(at)?.outcome {
                Outcome::Uploaded(value) => return Ok(Some(value)),
                Outcome::Aborted(_) => return Ok(None),
                // The device is silent, or its answer fits no request.
                _ => {}
            }
        }
        Ok(None)
    }

    /// Writes an object without keeping its earlier value.
    pub(crate) fn download_now(&mut self, at: Multiplexer, value: &[u8]) -> Result<(), Stop> {
        self.download_as(at, value, Mode::Shortest).map(|_| ())
    }

    /// Checks that a write had an effect. If a device confirms writes and ignores them, a case that judges the
    /// consequences of a write proves nothing. The bench checks this once per object in a run, when the object first
    /// gets a value other than the one before the case.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the object still has its earlier value.
    pub(crate) fn expect_effect(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<(), Stop> {
        let Some(before) = self.changes.value_before(multiplexer).filter(|before| *before != value).map(<[u8]>::to_vec)
        else {
            return Ok(());
        };
        if self.knowledge.takes.contains(&multiplexer) {
            return Ok(());
        }
        let Outcome::Uploaded(now) = self.unjudged(|bench| bench.upload(multiplexer))?.outcome else { return Ok(()) };
        if now == before {
            let duty = format!("{multiplexer} has the value that was written and confirmed");
            return Err(Stop::Inconclusive(Reason::new(duty, Bytes(value).to_string(), Bytes(&now).to_string())));
        }
        self.knowledge.takes.insert(multiplexer);
        Ok(())
    }

    /// Sends one SDO message, in or out of place, and waits for one response.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn exchange(&mut self, request: &Request, what: impl Into<String>) -> Result<Reply, Stop> {
        self.exchange_within(request, what.into(), self.timing().sdo_response)
    }

    /// Sends one SDO message that must not be answered, and waits for the time of silence.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn send_unanswered(&mut self, request: &Request, what: impl Into<String>) -> Result<Reply, Stop> {
        self.exchange_within(request, what.into(), self.silence())
    }

    fn exchange_within(&mut self, request: &Request, what: String, span: Duration) -> Result<Reply, Stop> {
        self.drain()?;
        // The first message of a dialogue names an object, and waits until there is time for the whole dialogue.
        if request.multiplexer().is_some() {
            self.traffic.wait_for_time(self.knowledge.slowest_answer)?;
        } else {
            self.traffic.wait_for_quiet(self.knowledge.slowest_answer)?;
        }
        self.send_request(request)?;
        let frame = self.wait_for_response(span)?;
        // After these requests a segment of a block may follow, which has no command specifier.
        let is_block = matches!(request, Request::StartBlockUpload | Request::ConfirmBlockUpload { .. });
        if let Some(frame) = frame.filter(|frame| !is_block || frame.bytes()[0] == ABORT) {
            self.judge_answer(request.multiplexer(), &frame);
        }
        let response = frame.and_then(|frame| Response::read(frame.data()).ok());
        Ok(Reply { subject: subject_of(request), what, response, frame })
    }

    /// Reads an object and requires this value; `duty` says why the object must have it.
    ///
    /// # Errors
    /// A breach if the object can't be read.
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

    /// Reads an object again and requires its earlier value; `duty` says why.
    ///
    /// # Errors
    /// A breach if the object can't be read; the errors of [`Bench::expect_same`].
    pub(crate) fn expect_again(
        &mut self,
        at: Multiplexer,
        before: &[u8],
        duty: impl Into<Cow<'static, str>>,
    ) -> Judged {
        let now = self.upload(at)?.value()?;
        self.expect_same(at, before, now, duty)
    }

    /// Requires that a value that was read is the earlier one; `duty` says why. Another value of an object that changes by
    /// itself proves nothing.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the object has changed by itself.
    pub(crate) fn expect_same(
        &mut self,
        at: Multiplexer,
        right: &[u8],
        found: Vec<u8>,
        duty: impl Into<Cow<'static, str>>,
    ) -> Judged {
        if found != right && found.len() == right.len() && self.changes_by_itself(at) {
            let [right, found] = [right, &*found].map(|value| Observation::Value(value.to_vec()).to_string());
            return Err(Stop::Inconclusive(Reason::new(format!("{at} stays the same during the case"), right, found)));
        }
        self.check(demand(found == right, || {
            let breach = Breach::new(at, duty).expected(Observation::Value(right.to_vec()));
            breach.found(Observation::Value(found))
        }))
    }

    /// Waits for a response without sending a request.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub(crate) fn wait_for_late_response(&mut self) -> Result<Option<Frame>, Stop> {
        self.wait_for_response(self.silence())
    }

    /// Reads an object again and requires that it still has its earlier value.
    ///
    /// # Errors
    /// A breach if the object can't be read any more.
    pub(crate) fn expect_unchanged(&mut self, multiplexer: Multiplexer, before: &[u8]) -> Judged {
        self.expect_again(multiplexer, before, format!("{multiplexer} keeps its value"))
    }

    /// Requires that the server still serves a correct request after the stimulus of the case.
    ///
    /// # Errors
    /// A breach if the server does not.
    pub(crate) fn expect_served(&mut self, circumstance: &str) -> Judged {
        let usual = self.knowledge.device_type.clone();
        let value = self.upload(DEVICE_TYPE)?.under(circumstance).value()?;
        let is_right = usual.as_ref().is_none_or(|usual| value == *usual);
        self.check(demand(is_right, || {
            let breach = Breach::new(DEVICE_TYPE, format!("an upload {circumstance} gives the object's value"));
            breach.expected(Observation::Value(usual.unwrap_or_default())).found(Observation::Value(value))
        }))
    }

    fn transfer(&mut self, transfer: Transfer, first: Request, what: String) -> Result<Attempt, Stop> {
        let stores = first.multiplexer().is_some_and(|object| {
            matches!(object.index.0, object::STORE_PARAMETERS | object::RESTORE_DEFAULT_PARAMETERS)
        });
        let multiplexer = transfer.multiplexer();
        // Non-volatile memory wears out, so it is written only once.
        let has_succeeded = |(outcome, _): &(Outcome, Vec<Frame>)| {
            stores || matches!(outcome, Outcome::Uploaded(_) | Outcome::Downloaded)
        };
        let (outcome, responses) = self.between_others(has_succeeded, move |bench| {
            bench.drain()?;
            let asked = bench.now();
            let mut line = BenchLine { bench, multiplexer, stores, asked, responses: Vec::new() };
            let outcome = transfer.clone().carry_out(first, &mut line)?;
            Ok((outcome, line.responses))
        })?;
        let outcome = self.of_described_size(multiplexer, outcome, responses.first());
        if outcome.own_abort().is_none() {
            self.knowledge.served += 1;
        }
        if let (DEVICE_TYPE, Outcome::Uploaded(value)) = (multiplexer, &outcome) {
            self.knowledge.device_type.get_or_insert_with(|| value.clone());
        }
        Ok(Attempt { multiplexer, what, outcome, responses })
    }

    /// Cuts an uploaded value to the size of the object's data type, if the server left the number of its bytes open
    /// (7.2.4.3.6), which it may do at one time and not at another.
    fn of_described_size(&self, multiplexer: Multiplexer, outcome: Outcome, first: Option<&Frame>) -> Outcome {
        let is_open = first.and_then(|frame| Response::read(frame.data()).ok()).is_some_and(|response| {
            matches!(response, Response::InitiateUpload { payload: Payload::ExpeditedUnsized(_), .. })
        });
        let description = self.target.description.as_ref().filter(|_| is_open);
        let entry = description.and_then(|description| description.dictionary.entry(multiplexer).ok());
        match (outcome, entry.and_then(|entry| entry.data_type.bits())) {
            (Outcome::Uploaded(mut value), Some(bits)) => {
                value.truncate(bits.div_ceil(8) as usize);
                Outcome::Uploaded(value)
            }
            (outcome, _) => outcome,
        }
    }

    /// Performs a transfer, and repeats it if it ended badly while others used the server: one client's request ends
    /// another client's transfer. The breaches of a discarded attempt are forgotten.
    pub(super) fn between_others<T>(
        &mut self,
        has_succeeded: impl Fn(&T) -> bool,
        mut transfer: impl FnMut(&mut Self) -> Result<T, Stop>,
    ) -> Result<T, Stop> {
        for _ in 1..TRIES {
            let mark = self.log.mark();
            self.traffic.wait_for_time(self.knowledge.slowest_answer)?;
            let before = self.traffic.clients.requests();
            let result = transfer(self)?;
            if self.traffic.clients.requests() == before || has_succeeded(&result) {
                return Ok(result);
            }
            self.log.forget_since(mark);
            self.traffic.wait_for_pause(self.knowledge.slowest_answer)?;
        }
        let before = self.traffic.clients.requests();
        let result = transfer(self)?;
        if self.traffic.clients.requests() != before && !has_succeeded(&result) {
            self.traffic.clients.add_collision();
        }
        Ok(result)
    }

    /// Sends one SDO message and does not wait.
    ///
    /// # Errors
    /// The errors of [`Bench::send`].
    pub(crate) fn send_request(&mut self, request: &Request) -> Result<(), Stop> {
        let cob_id = sdo::REQUEST_BASE + u16::from(self.node().raw());
        self.send(&request.to_frame(cob_id)).map(|_| ())
    }

    pub(super) fn wait_for_response(&mut self, span: Duration) -> Result<Option<Frame>, Stop> {
        let cob_id = sdo::RESPONSE_BASE + u16::from(self.node().raw());
        self.wait_for(span, |record| (record.frame.cob_id() == Some(cob_id)).then_some(record.frame))
    }
}

/// The device's default SDO server, as the line for the transfer of one object.
struct BenchLine<'l, 'b> {
    bench: &'l mut Bench<'b>,
    multiplexer: Multiplexer,
    /// Whether the transfer stores parameters, which takes longer than any other access.
    stores: bool,
    asked: Timestamp,
    responses: Vec<Frame>,
}

impl ServerLine for BenchLine<'_, '_> {
    type Error = Stop;

    fn now(&self) -> Timestamp {
        self.bench.now()
    }

    fn send(&mut self, request: &Request) -> Result<(), Stop> {
        self.asked = self.bench.now();
        self.bench.send_request(request)
    }

    fn receive(&mut self) -> Result<Option<Frame>, Stop> {
        /// The first frames of a long upload show its form well enough.
        const KEPT: usize = 256;
        let timing = self.bench.timing();
        let patience = if self.stores { timing.store } else { timing.sdo_response };
        let Some(frame) = self.bench.wait_for_response(patience)? else { return Ok(None) };
        if !self.stores {
            let duration = self.bench.now().since(self.asked);
            self.bench.knowledge.slowest_answer = self.bench.knowledge.slowest_answer.max(duration);
        }
        // A device that writes its memory may answer late although its timers are right.
        let is_idle = !self.bench.traffic.watch.has_stored();
        if self.multiplexer == DEVICE_TYPE && self.responses.is_empty() && is_idle {
            self.bench.note_answer(self.asked);
        }
        self.bench.judge_answer(Some(self.multiplexer), &frame);
        if self.responses.len() < KEPT {
            self.responses.push(frame);
        }
        Ok(Some(frame))
    }
}

/// The first four bytes of a value as a little-endian number.
pub fn number(value: &[u8]) -> u32 {
    value.iter().take(4).rev().fold(0, |number, &byte| number << 8 | u32::from(byte))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::{frame, table, with_bench};
    use crate::situation::Situation;
    use crate::verdict::Grade;
    use canvass_analyzer::wire::sdo::AbortCode;

    /// Other traffic of this node and of others does not disturb a transfer.
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

    /// The bench puts back a value that a case has written.
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
            let heartbeat_time = Multiplexer::new(object::PRODUCER_HEARTBEAT_TIME, 0);
            bench.write(heartbeat_time, &[0xE8, 0x03]).unwrap();
            assert_eq!(*time.borrow(), [0xE8, 0x03]);
            let remains = bench.finish();
            assert!(remains.notes.is_empty() && remains.evidence.frames().count() > 4);
        });
        assert_eq!(*time.borrow(), [0, 0]);
    }
}
