//! The time between two frames of a sequence: waiting for answers, for silence, or for the answer to a request that
//! replaces waiting for silence.

use super::{Cause, Executor, LATE_ANSWER, LATELY, MISSING_ANSWER, MOST_QUIET, Pace, SLOW_ANSWER, Stop, WEDGED};
use crate::oracle::Violation;
use crate::stand::TestStand;
use crate::stimulus::Stimulus;
use crate::trust::Trusts;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::lss;
use canvass_bus::BusError;
use canvass_traces::{Direction, Duration, Frame, Timestamp};

/// The wait after the last frame.
#[derive(Debug)]
pub(crate) struct Waits {
    pub pace: Pace,
    /// The required duration of silence, and whether a request can replace waiting for silence.
    pub trusts: Trusts,
    /// Whether a forbidden answer to this frame is also recognised after the next frame.
    pub followed: bool,
    /// The reason of the current or last wait.
    awaited: Cause,
    /// Whether the read at the end of a sequence is under way. Its missing answer is a violation of its own.
    pub probing: bool,
    /// The last frame that the device or another node has sent.
    heard: Option<Frame>,
    /// Number of own frames that were handed over and have not been on the bus yet.
    pub outstanding: usize,
}

impl Waits {
    pub fn new(quiet: Duration) -> Self {
        Self {
            pace: Pace::Careful,
            trusts: Trusts::new(quiet),
            followed: false,
            awaited: Cause::Answer,
            probing: false,
            heard: None,
            outstanding: 0,
        }
    }

    /// Resets the waits for a new sequence.
    pub fn begin(&mut self, pace: Pace) {
        (self.pace, self.probing, self.outstanding) = (pace, false, 0);
    }

    /// The required duration of silence.
    pub fn quiet(&self) -> Duration {
        self.trusts.quiet()
    }

    /// The time after which a known missing answer counts as missing again.
    pub(crate) fn missing_after(&self) -> Duration {
        self.quiet().times(MISSING_ANSWER)
    }

    /// Maximum wait for silence while other nodes keep the bus busy.
    fn longest(&self) -> Duration {
        self.quiet().times(MOST_QUIET)
    }
}

impl Executor {
    /// Tells the models that no answer is under way any more.
    fn be_quiet(&mut self, now: Timestamp) {
        self.waits.trusts.awaits_lss = false;
        self.oracle.quiet(now);
    }

    /// Whether the fuzzer need not wait for silence, because a forbidden answer would come before the answer to the
    /// next frame.
    fn may_hurry(&self) -> bool {
        self.waits.pace == Pace::Swift
            && self.waits.followed
            && !self.oracle.may_be_answered()
            && !self.known.answers_too_much()
    }

    /// Waits until the answers that are due have come, or until silence has lasted long enough if no answer is due.
    pub(super) fn settle(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        let begun = stand.bus().now();
        let ended = self.wait_for_answers(stand);
        self.tally.spent.add(self.waits.awaited, stand.bus().now().since(begun));
        ended
    }

    fn wait_for_answers(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        let answer = self.knowledge.patience.answer;
        let mut quiet = self.waits.quiet();
        let must_be_sure = self.waits.pace == Pace::Careful || self.oracle.may_be_answered();
        if must_be_sure && !stand.is_repeatable() {
            // A later answer would be taken for the answer to the next frame.
            quiet = quiet.times(LATE_ANSWER);
        }
        let mut was_due = false;
        let mut until = Timestamp::MAX;
        let mut known_by = self.known_by(stand);
        let longest = stand.bus().now() + quiet.times(MOST_QUIET);
        let begun = stand.bus().now();
        loop {
            let due = self.oracle.due();
            let awaited = self.oracle.awaits();
            let deadline = match due {
                _ if self.waits.outstanding > 0 => stand.bus().now() + answer,
                Some(due) => due.min(known_by),
                None if was_due && !self.oracle.is_open() => return Ok(()),
                None if self.may_hurry() => return Ok(()),
                None if self.may_ask(stand) && self.oracle.may_be_asked() => return self.ask(stand),
                None if self.may_ask(stand)
                    && self.oracle.is_lost()
                    && let Some(at) = self.unnamed() =>
                {
                    return self.find_server(stand, at);
                }
                None => {
                    if until == Timestamp::MAX {
                        until = stand.bus().now() + quiet;
                    }
                    until
                }
            };
            was_due |= due.is_some();
            match self.receive(stand, deadline)? {
                // Several answers may be under way. Heartbeats and PDOs come all the time and don't prolong the wait.
                Received::Answer => {
                    until = Timestamp::MAX;
                    self.waits.awaited = Cause::Answer;
                    self.remember_slow(awaited, stand.bus().now().since(begun));
                }
                // The answer may be waiting for the bus.
                Received::Bystander if stand.bus().now() < longest => until = Timestamp::MAX,
                Received::Bystander | Received::Other => {}
                Received::Nothing => {
                    self.waits.awaited = if due.is_some() { Cause::Missing } else { Cause::Silence };
                    self.oracle.expire(stand.bus().now())?;
                    if self.waits.outstanding > 0 {
                        // The frame was not sent, so nothing can be said about the device.
                        self.waits.outstanding = 0;
                    } else if let Some(due) = due {
                        if stand.bus().now() >= known_by {
                            known_by = Timestamp::MAX;
                            self.is_missing_as_before(due)?;
                            self.give_up(stand)?;
                        }
                    } else {
                        self.be_quiet(stand.bus().now());
                        return Ok(());
                    }
                }
            }
        }
    }

    /// The time at which a missing answer is compared with the answers known to be missing or slow.
    fn known_by(&self, stand: &mut dyn TestStand) -> Timestamp {
        let is_known = match self.waits.pace {
            Pace::Careful => self.known.presumes() && !stand.is_repeatable(),
            Pace::Swift => self.known.shortens_waits(),
        };
        if is_known { stand.bus().now() + self.waits.missing_after() } else { Timestamp::MAX }
    }

    /// Counts a slow answer, such as that of a server that ends a block with missing segments by its own time-out.
    fn remember_slow(&mut self, awaited: Option<&'static str>, took: Duration) {
        if let Some(awaited) =
            awaited.filter(|_| self.waits.pace == Pace::Swift && took > self.waits.quiet().times(SLOW_ANSWER))
        {
            self.known.add_slow(awaited);
        }
    }

    /// Waits once more for an answer that was missing. Returns its time after the last own frame, if it comes after all.
    pub(crate) fn late_answer(&mut self, stand: &mut dyn TestStand, can_id: u16) -> Result<Option<Duration>, BusError> {
        let own = self.history.evidence().iter().rfind(|record| record.direction == Direction::Tx);
        let asked = own.map_or_else(|| stand.bus().now(), |record| record.timestamp);
        let until = stand.bus().now() + self.knowledge.patience.answer;
        while let Some(record) = stand.bus().receive(until)? {
            let (at, id) = (record.timestamp, record.frame.cob_id());
            self.history.note(record);
            if id == Some(can_id) {
                return Ok(Some(at.since(asked)));
            }
        }
        Ok(None)
    }

    /// Aborts a transfer whose answer is known to be slow, because it was judged before.
    fn give_up(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        let is_too_slow = self.oracle.awaits().is_some_and(|awaited| self.known.is_too_slow(awaited));
        if self.waits.pace == Pace::Careful || !is_too_slow {
            return Ok(());
        }
        Ok(self.hand_over(stand, self.requests.abort)?)
    }

    /// Ends the sequence if the answer due at `due` is known to be missing. The fuzzer has waited the full time twice:
    /// when the answer was missing for the first time, and when this violation was repeated.
    fn is_missing_as_before(&mut self, due: Timestamp) -> Result<(), Stop> {
        match self.oracle.clone().expire(due) {
            // A missing answer that is not the violation to be shown again ends the try, too, however slow the answer
            // is. But a start may take long, and the violation may come after it.
            Err(violation) if self.is_known(&violation) || self.known.presumes() && !self.oracle.is_booting() => {
                Err(violation.into())
            }
            _ => Ok(()),
        }
    }

    fn is_known(&self, violation: &Violation) -> bool {
        let key = if self.waits.probing { WEDGED } else { (violation.property, violation.rule) };
        self.known.is_known_silence(key, self.waits.pace)
    }

    /// Whether a request can replace waiting for silence: its answer comes after the earlier frames have taken effect.
    fn may_ask(&self, stand: &dyn TestStand) -> bool {
        self.waits.pace == Pace::Swift && self.waits.trusts.are_in_order() && !stand.is_repeatable()
    }

    /// Reads an object when the state of the server is not known. The value shows that the server has no transfer and
    /// has answered the earlier requests. If the server takes the request for something else, an abort ends its
    /// transfer.
    fn find_server(&mut self, stand: &mut dyn TestStand, at: Multiplexer) -> Result<(), Stop> {
        self.waits.awaited = Cause::Question;
        let executions = self.tally.executions;
        let found = self.has_read(stand, at)?;
        self.be_quiet(stand.bus().now());
        if !found && self.oracle.serves_sdo() {
            self.hand_over(stand, self.requests.abort)?;
            self.ask(stand)?;
        }
        self.tally.executions = executions;
        Ok(())
    }

    /// A mandatory object that none of the last requests has named, so that only the answer to this request names it.
    fn unnamed(&self) -> Option<Multiplexer> {
        let names = |at: &Multiplexer| {
            self.history
                .lately()
                .take(LATELY)
                .any(|stimulus| stimulus.frame.data().get(1..4) == Some(&at.to_bytes()[..]))
        };
        let every =
            [(object::DEVICE_TYPE, 0), (object::ERROR_REGISTER, 0), (object::IDENTITY, 0), (object::IDENTITY, 1)];
        every.into_iter().map(|(index, sub)| Multiplexer::new(index, sub)).find(|at| !names(at))
    }

    /// Whether the value of the object is received before silence has lasted long enough.
    fn has_read(&mut self, stand: &mut dyn TestStand, at: Multiplexer) -> Result<bool, Stop> {
        self.hand_over(stand, self.requests.read(at))?;
        // The last value read before is no answer to this request.
        self.waits.heard = None;
        let longest = stand.bus().now() + self.waits.longest();
        loop {
            let deadline = longest.min(stand.bus().now() + self.waits.missing_after());
            match self.receive(stand, deadline)? {
                Received::Nothing => {
                    self.oracle.expire(stand.bus().now())?;
                    self.waits.outstanding = 0;
                    return Ok(false);
                }
                Received::Answer if self.waits.heard.is_some_and(|frame| self.requests.is_value(&frame, at)) => {
                    return Ok(true);
                }
                _ => {}
            }
        }
    }

    /// Sends a frame that is not part of the sequence.
    pub(super) fn hand_over(&mut self, stand: &mut dyn TestStand, frame: Frame) -> Result<(), BusError> {
        stand.bus().send(&frame)?;
        self.history.send(Stimulus::settle(frame));
        self.waits.outstanding += 1;
        Ok(())
    }

    /// Reads 1000h and judges all frames until the answer. This exchange is not counted, as it is not part of the
    /// sequence.
    fn ask(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        self.waits.awaited = Cause::Question;
        let executions = self.tally.executions;
        self.hand_over(stand, self.requests.probe)?;
        let begun = stand.bus().now();
        let until = begun + self.knowledge.patience.answer;
        let longest = begun + self.waits.longest();
        loop {
            let due = self.oracle.due();
            let deadline = match due {
                _ if self.waits.outstanding > 0 => until,
                Some(due) => due,
                None if self.oracle.may_be_asked() => break,
                // A frame that came meanwhile leaves open whether this request is answered.
                None => longest.min(stand.bus().now() + self.waits.quiet().times(LATE_ANSWER)),
            };
            if self.receive(stand, deadline)? == Received::Nothing {
                self.oracle.expire(stand.bus().now())?;
                if self.waits.outstanding == 0 && due.is_none() {
                    break;
                }
                self.waits.outstanding = 0;
            }
        }
        self.tally.executions = executions;
        self.be_quiet(stand.bus().now());
        Ok(())
    }

    /// Waits until the time `until` and judges the frames that are received.
    pub(super) fn pass(&mut self, stand: &mut dyn TestStand, until: Timestamp) -> Result<(), Stop> {
        let begun = stand.bus().now();
        let ended = self.listen(stand, until);
        self.tally.spent.add(Cause::Pause, stand.bus().now().since(begun));
        ended
    }

    fn listen(&mut self, stand: &mut dyn TestStand, until: Timestamp) -> Result<(), Stop> {
        let mut heard = stand.bus().now();
        loop {
            let deadline = self.oracle.due().unwrap_or(until).min(until);
            match self.receive(stand, deadline)? {
                Received::Answer => heard = stand.bus().now(),
                Received::Bystander | Received::Other => {}
                Received::Nothing => {
                    let now = stand.bus().now();
                    self.oracle.expire(now)?;
                    if now >= until {
                        // After a short pause an answer may still be under way.
                        if now.since(heard) >= self.waits.quiet() {
                            self.be_quiet(stand.bus().now());
                        }
                        return Ok(());
                    }
                }
            }
        }
    }

    /// Receives the next frame, if one comes before the deadline.
    fn receive(&mut self, stand: &mut dyn TestStand, deadline: Timestamp) -> Result<Received, Stop> {
        let Some(record) = stand.bus().receive(deadline)? else { return Ok(Received::Nothing) };
        if record.frame.is_error() {
            return Ok(Received::Other);
        }
        let (now, frame, own) = (record.timestamp, record.frame, record.direction == Direction::Tx);
        self.history.note(record);
        if own {
            self.waits.outstanding = self.waits.outstanding.saturating_sub(1);
            self.oracle.sent(now, &frame, &mut self.tally.coverage)?;
            self.tally.executions += u64::from(self.oracle.judges(&frame));
            return Ok(Received::Answer);
        }
        self.waits.heard = Some(frame);
        self.oracle.received(now, &frame, &mut self.tally.coverage)?;
        let id = frame.cob_id();
        let is_answer = id == Some(self.requests.response) || id == Some(lss::SLAVE_CAN_ID);
        Ok(match id {
            _ if is_answer => Received::Answer,
            Some(id) if self.knowledge.bystanders.contains(&id) => Received::Bystander,
            _ => Received::Other,
        })
    }
}

/// The kind of a received frame.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Received {
    Nothing,
    /// An own frame, or an answer of a server or slave.
    Answer,
    /// A frame of another node, or a frame outside the device's predefined connection set.
    Bystander,
    /// Any other frame, such as a heartbeat or a PDO.
    Other,
}
