//! What comes between two frames of a sequence: answers, silence, and what takes the place of waiting for it.

use super::{
    Cause, Executor, LATE_ANSWER, LATELY, LONGEST_EVIDENCE, MISSING_ANSWER, MOST_QUIET, MOST_SLOW, Pace, SLOW_ANSWER,
    Stop, WEDGED,
};
use crate::oracle::Violation;
use crate::property::Property;
use crate::stand::TestStand;
use crate::stimulus::Stimulus;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::lss;
use canvass_analyzer::wire::sdo::{Payload, Request, Response};
use canvass_bus::BusError;
use canvass_traces::{Direction, Duration, Frame, Timestamp};

impl Executor {
    /// Nothing is under way any more.
    fn be_quiet(&mut self, now: Timestamp) {
        self.trusts.awaits_lss = false;
        self.oracle.quiet(now);
    }

    /// Whether nobody need wait for silence: an answer that must not come shows before the answer to the next frame.
    fn may_hurry(&self) -> bool {
        self.pace == Pace::Swift && self.followed && !self.oracle.may_be_answered() && !self.answers_too_much()
    }

    /// Whether the device is known to answer where nothing is due: that would be taken for the answer to the next frame.
    fn answers_too_much(&self) -> bool {
        self.known.iter().any(|(property, _)| matches!(property, Property::OneAnswer | Property::Silent))
    }

    /// Until what is due has come, or no answer has come for a while where none is due.
    pub(super) fn settle(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        let begun = stand.bus().now();
        let ended = self.wait_for_answers(stand);
        self.spent.add(self.awaited, stand.bus().now().since(begun));
        ended
    }

    fn wait_for_answers(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        let answer = self.knowledge.patience.answer;
        let mut quiet = self.trusts.quiet();
        let must_be_sure = self.pace == Pace::Careful || self.oracle.may_be_answered();
        if must_be_sure && !stand.is_repeatable() {
            // What comes later would be taken for the answer to the next frame.
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
                _ if self.outstanding > 0 => stand.bus().now() + answer,
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
                // Several answers may be under way; heartbeats and PDOs come all the time.
                Received::Answer => {
                    until = Timestamp::MAX;
                    self.awaited = Cause::Answer;
                    self.remember_slow(awaited, stand.bus().now().since(begun));
                }
                // The answer may wait for the bus.
                Received::Bystander if stand.bus().now() < longest => until = Timestamp::MAX,
                Received::Bystander | Received::Other => {}
                Received::Nothing => {
                    self.awaited = if due.is_some() { Cause::Missing } else { Cause::Silence };
                    self.oracle.expire(stand.bus().now())?;
                    if self.outstanding > 0 {
                        // The bus does not take the frame: nothing can be said about the device.
                        self.outstanding = 0;
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

    /// When an answer that has not come is compared with those that are known not to come, or to be slow.
    fn known_by(&self, stand: &mut dyn TestStand) -> Timestamp {
        let is_known = match self.pace {
            Pace::Careful => self.presumed.is_some() && !stand.is_repeatable(),
            Pace::Swift => self.presumed.is_some() || !self.known_silence.is_empty() || !self.slow.is_empty(),
        };
        if is_known { stand.bus().now() + self.missing_after() } else { Timestamp::MAX }
    }

    /// After that time an answer is missing that is known not to come.
    pub(super) fn missing_after(&self) -> Duration {
        self.trusts.quiet().times(MISSING_ANSWER)
    }

    /// Remembers what took long: a server that ends a block by a time-out of its own, where segments were missing.
    fn remember_slow(&mut self, awaited: Option<&'static str>, took: Duration) {
        if let Some(awaited) =
            awaited.filter(|_| self.pace == Pace::Swift && took > self.trusts.quiet().times(SLOW_ANSWER))
        {
            *self.slow.entry(awaited).or_default() += 1;
        }
    }

    /// Aborts a transfer whose answer is known to be slow: it was judged when it came before.
    fn give_up(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        let slow = self.oracle.awaits().and_then(|awaited| self.slow.get(awaited));
        if self.pace == Pace::Careful || slow.is_none_or(|&times| times < MOST_SLOW) {
            return Ok(());
        }
        Ok(self.hand_over(stand, self.abort)?)
    }

    /// Ends the sequence where the answer that is due until then is one that is known not to come: the whole of its time
    /// was waited for when it was missing for the first time, and when that was repeated.
    fn is_missing_as_before(&mut self, due: Timestamp) -> Result<(), Stop> {
        match self.oracle.clone().expire(due) {
            // A try that shows something else than what it is to show has failed, however slow the answer is. A start may take
            // long, and what is to be shown may come after it.
            Err(violation) if self.is_known(&violation) || self.presumed.is_some() && !self.oracle.is_booting() => {
                self.has_hurried = true;
                Err(violation.into())
            }
            _ => Ok(()),
        }
    }

    fn is_known(&self, violation: &Violation) -> bool {
        let key = if self.probing { WEDGED } else { (violation.property, violation.rule) };
        self.presumed == Some(key) || self.pace == Pace::Swift && self.known_silence.contains(&key)
    }

    /// Whether a request can take the place of waiting: its answer comes when what was sent before it is done.
    fn may_ask(&self, stand: &dyn TestStand) -> bool {
        self.pace == Pace::Swift && self.trusts.are_in_order() && !stand.is_repeatable()
    }

    /// Reads an object where nobody knows what the server does: its value says that the server has no transfer, and has
    /// answered what came before. A server that takes the request for something else is made to end its transfer.
    fn find_server(&mut self, stand: &mut dyn TestStand, at: Multiplexer) -> Result<(), Stop> {
        self.awaited = Cause::Question;
        let executions = self.executions;
        let found = self.has_read(stand, at)?;
        self.be_quiet(stand.bus().now());
        if !found && self.oracle.serves_sdo() {
            self.hand_over(stand, self.abort)?;
            self.ask(stand)?;
        }
        self.executions = executions;
        Ok(())
    }

    /// An object of every device that no request of the last moment has named, so that only this answer names it.
    fn unnamed(&self) -> Option<Multiplexer> {
        let names = |at: &Multiplexer| {
            let last = self.sent.iter().rev().take(LATELY);
            last.into_iter().any(|stimulus| stimulus.frame.data().get(1..4) == Some(&at.to_bytes()[..]))
        };
        let every =
            [(object::DEVICE_TYPE, 0), (object::ERROR_REGISTER, 0), (object::IDENTITY, 0), (object::IDENTITY, 1)];
        every.into_iter().map(|(index, sub)| Multiplexer::new(index, sub)).find(|at| !names(at))
    }

    /// Whether the value of that object comes, before nothing has come for a while.
    fn has_read(&mut self, stand: &mut dyn TestStand, at: Multiplexer) -> Result<bool, Stop> {
        let request = Request::upload(at).to_frame(self.probe.cob_id().unwrap_or_default());
        self.hand_over(stand, request)?;
        // The value that was read last is no answer to this request.
        self.heard = None;
        let longest = stand.bus().now() + self.trusts.quiet().times(MOST_QUIET);
        loop {
            let deadline = longest.min(stand.bus().now() + self.missing_after());
            match self.receive(stand, deadline)? {
                Received::Nothing => {
                    self.oracle.expire(stand.bus().now())?;
                    self.outstanding = 0;
                    return Ok(false);
                }
                Received::Answer if self.heard.is_some_and(|frame| self.is_value(&frame, at)) => return Ok(true),
                _ => {}
            }
        }
    }

    /// Whether that is the value of that object, in one frame.
    pub(super) fn is_value(&self, frame: &Frame, at: Multiplexer) -> bool {
        let response = Response::read(frame.data()).ok().filter(|_| frame.cob_id() == Some(self.response));
        let Some(Response::InitiateUpload { multiplexer, payload }) = response else { return false };
        multiplexer == at && !matches!(payload, Payload::Segmented(_) | Payload::SegmentedUnsized)
    }

    /// Sends a frame that is none of the sequence.
    pub(super) fn hand_over(&mut self, stand: &mut dyn TestStand, frame: Frame) -> Result<(), BusError> {
        stand.bus().send(&frame)?;
        self.sent.push(Stimulus::settle(frame));
        self.outstanding += 1;
        Ok(())
    }

    /// Reads 1000h; what comes until the answer is judged. It is no exchange of the sequence, and not counted as one.
    fn ask(&mut self, stand: &mut dyn TestStand) -> Result<(), Stop> {
        self.awaited = Cause::Question;
        let executions = self.executions;
        self.hand_over(stand, self.probe)?;
        let begun = stand.bus().now();
        let until = begun + self.knowledge.patience.answer;
        let longest = begun + self.trusts.quiet().times(MOST_QUIET);
        loop {
            let due = self.oracle.due();
            let deadline = match due {
                _ if self.outstanding > 0 => until,
                Some(due) => due,
                None if self.oracle.may_be_asked() => break,
                // What came meanwhile leaves open whether it is answered.
                None => longest.min(stand.bus().now() + self.trusts.quiet().times(LATE_ANSWER)),
            };
            if self.receive(stand, deadline)? == Received::Nothing {
                self.oracle.expire(stand.bus().now())?;
                if self.outstanding == 0 && due.is_none() {
                    break;
                }
                self.outstanding = 0;
            }
        }
        self.executions = executions;
        self.be_quiet(stand.bus().now());
        Ok(())
    }

    /// Lets time pass.
    pub(super) fn pass(&mut self, stand: &mut dyn TestStand, until: Timestamp) -> Result<(), Stop> {
        let begun = stand.bus().now();
        let ended = self.listen(stand, until);
        self.spent.add(Cause::Pause, stand.bus().now().since(begun));
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
                        // In a short pause an answer may still be under way.
                        if now.since(heard) >= self.trusts.quiet() {
                            self.be_quiet(stand.bus().now());
                        }
                        return Ok(());
                    }
                }
            }
        }
    }

    /// The next frame, if there is one until the deadline.
    fn receive(&mut self, stand: &mut dyn TestStand, deadline: Timestamp) -> Result<Received, Stop> {
        let Some(record) = stand.bus().receive(deadline)? else { return Ok(Received::Nothing) };
        if record.frame.is_error() {
            return Ok(Received::Other);
        }
        let (now, frame, own) = (record.timestamp, record.frame, record.direction == Direction::Tx);
        if self.keep {
            if self.evidence.len() >= 2 * LONGEST_EVIDENCE {
                self.evidence.drain(..LONGEST_EVIDENCE);
            }
            self.evidence.push(record);
        }
        if own {
            self.outstanding = self.outstanding.saturating_sub(1);
            self.oracle.sent(now, &frame, &mut self.coverage)?;
            self.executions += u64::from(self.oracle.judges(&frame));
            return Ok(Received::Answer);
        }
        self.heard = Some(frame);
        self.oracle.received(now, &frame, &mut self.coverage)?;
        let id = frame.cob_id();
        let is_answer = id == Some(self.response) || id == Some(lss::SLAVE_CAN_ID);
        Ok(match id {
            _ if is_answer => Received::Answer,
            Some(id) if self.knowledge.bystanders.contains(&id) => Received::Bystander,
            _ => Received::Other,
        })
    }
}

/// What was received.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Received {
    Nothing,
    /// An own frame, or one with which servers and slaves answer.
    Answer,
    /// What others send, or the device beside its services.
    Bystander,
    /// What comes by itself.
    Other,
}
