//! Reference models of a CANopen device: the frames that it must, may and must not send.
//!
//! The models are written from the standard and share no code with the simulated device, because an oracle that shares
//! code with a device shares its mistakes. Each service has a file; this file passes each frame to its service. If the
//! standard leaves a choice, every choice is right. After a frame that the standard does not describe, a model judges
//! nothing until it knows the state again.

mod clause;
mod codes;
mod emcy;
mod expected_values;
mod layer_setting;
mod lmt;
mod lss;
mod nmt;
mod pdo;
mod pdo_rules;
mod rpdo;
mod sdo;
mod sync_count;
mod violation;

use super::Knowledge;
use super::coverage::Coverage;
use super::property::Property;
use super::stimulus::Start;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::{error_control, lss as lss_wire, nmt as nmt_wire, sdo as sdo_wire};
use canvass_traces::{Duration, Frame, Timestamp};
use expected_values::ExpectedValues;
use layer_setting::Effect;
use std::sync::Arc;

pub use violation::{Defect, DeviceState, Symptom, Violation, WrongAnswer};

/// Frames whose distance is smaller than this leave no room for other frames between them.
const BURST: Duration = Duration::from_millis(2);

/// The reference models of one device.
#[derive(Clone, Debug)]
pub(crate) struct Oracle {
    knowledge: Arc<Knowledge>,
    expected_values: ExpectedValues,
    nmt: nmt::Slave,
    sdo: sdo::Server,
    lss: lss::Slave,
    lmt: lmt::Slave,
    pdo: pdo::Pdos,
    emcy: emcy::Watch,
    /// The time of the last frame of another node.
    passed: Timestamp,
    /// Whether a frame had an effect that the models don't follow. If so, nothing is judged until the next start.
    blind: bool,
}

impl Oracle {
    /// The models of a device that is about to start.
    pub fn new(knowledge: Arc<Knowledge>) -> Self {
        Self {
            expected_values: ExpectedValues::new(&knowledge),
            nmt: nmt::Slave::new(knowledge.patience.jitter, knowledge.services.boot_up_message),
            sdo: sdo::Server::new(),
            lss: lss::Slave::new(),
            lmt: lmt::Slave::new(),
            pdo: pdo::Pdos::new(&knowledge),
            emcy: emcy::Watch::new(),
            passed: Timestamp::ZERO,
            blind: false,
            knowledge,
        }
    }

    /// Handles a start of the device in the state `start`.
    pub fn start(&mut self, now: Timestamp, start: Start) {
        self.expected_values.power_on(&self.knowledge);
        self.nmt.start(now, start);
        self.sdo.reset();
        self.lss.start(start);
        self.lmt.start();
        self.pdo.reset();
        self.emcy.reset();
        self.blind = false;
    }

    /// Applies a frame of the fuzzer whose transmission ended at `now`.
    ///
    /// # Errors
    /// [`Violation`] if an answer that was due before has not come.
    pub fn sent(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        if self.blind {
            if frame.cob_id() == Some(nmt_wire::CAN_ID) {
                self.nmt.restarted(now, frame, &self.knowledge);
            }
            return Ok(());
        }
        self.expire(now)?;
        self.nmt.passed(now);
        self.emcy
            .provoked(frame, frame.cob_id() == Some(sdo_wire::REQUEST_BASE + u16::from(self.knowledge.node.raw())));
        let Some(can_id) = frame.id().as_standard() else {
            coverage.sdo_frame(self.sdo.class(), super::coverage::Command::Extended, frame, &self.knowledge);
            return Ok(());
        };
        if frame.is_remote() {
            return self.sent_remote(now, can_id);
        }
        let node = u16::from(self.knowledge.node.raw());
        match can_id {
            nmt_wire::CAN_ID => self.sent_nmt(now, frame),
            lss_wire::MASTER_CAN_ID if self.knowledge.services.lmt => {
                let effect = self.lmt.asked(now, frame, &self.knowledge, self.nmt.phase(), coverage);
                self.blind |= effect == Effect::Lost;
                Ok(())
            }
            lss_wire::MASTER_CAN_ID => {
                let effect = self.lss.asked(now, frame, &self.knowledge, self.nmt.phase(), coverage);
                self.blind |= effect == Effect::Lost;
                if let Effect::Boots = effect {
                    self.nmt.boots(now, &self.knowledge);
                }
                Ok(())
            }
            id if id == sdo_wire::REQUEST_BASE + node => {
                let served = self.nmt.serves_sdo();
                let lost = self.sdo.asked(now, frame, served, &self.knowledge, &mut self.expected_values, coverage);
                self.blind |= lost;
                Ok(())
            }
            // A producer of SYNC need not accept the SYNC of another producer.
            id if self.expected_values.is_sync(id) && self.expected_values.produces_sync() => {
                self.pdo.synchronises_itself();
                Ok(())
            }
            id if self.expected_values.is_sync(id) => {
                let writing = self.sdo.is_writing();
                self.pdo.synchronised(now, frame, writing, &self.nmt, &self.expected_values, &self.knowledge)
            }
            id => {
                let writes = self.expected_values.writes();
                let writing = self.sdo.is_writing() || self.sdo.is_busy();
                rpdo::received(now, frame, id, writing, &self.nmt, &mut self.expected_values, &self.knowledge);
                if self.sdo.is_busy() && self.expected_values.writes() != writes {
                    // A read under way may return the value before or after this frame.
                    self.expected_values.suspend();
                }
                Ok(())
            }
        }
    }

    fn sent_remote(&mut self, now: Timestamp, can_id: u16) -> Result<(), Violation> {
        if can_id == error_control::CAN_ID_BASE + u16::from(self.knowledge.node.raw()) {
            self.nmt.guarded(now, self.sdo.is_writing(), &self.expected_values, &self.knowledge);
        } else {
            let writing = self.sdo.is_writing();
            self.pdo.asked(now, can_id, writing, &self.nmt, &self.expected_values, &self.knowledge);
        }
        Ok(())
    }

    fn sent_nmt(&mut self, now: Timestamp, frame: &Frame) -> Result<(), Violation> {
        // A write under way may take effect before the command or not at all.
        let writing = self.sdo.is_writing();
        match self.nmt.commanded(now, frame, &self.knowledge) {
            nmt::Change::None => {}
            nmt::Change::State => {
                self.doubt(now);
                self.sdo.state_changed(now, self.nmt.serves_sdo(), self.late(), self.knowledge.patience.quiet);
                self.pdo.state_changed(now, &self.nmt);
            }
            nmt::Change::Reset(what) => {
                self.blind |= self.expected_values.bus_changed()
                    || self.lss.moves(&self.knowledge)
                    || self.sdo.may_move(&self.knowledge.services.bus_objects);
                self.expected_values.reset(&self.knowledge, what);
                self.sdo.reset();
                self.lss.reset_communication(now + self.nmt.grace());
                self.lmt.reset_communication();
                self.pdo.reset();
                self.emcy.reset();
            }
        }
        if writing && self.nmt.serves_sdo() != Served::Yes {
            self.expected_values.forget(Some(Multiplexer::new(0, 0)));
        }
        Ok(())
    }

    /// Time during which an SDO response that was already on its way may come.
    fn late(&self) -> Duration {
        self.nmt.grace().max(self.knowledge.patience.quiet)
    }

    /// Allows for an error without a report: a device whose EMCY is off or delayed may leave operational because of the
    /// error.
    fn doubt(&mut self, now: Timestamp) {
        if self.nmt.phase() == nmt::Phase::Operational && self.expected_values.errs_silently(&self.knowledge) {
            self.nmt.doubt(now);
        }
    }

    /// Checks a frame of the device whose transmission ended at `now`.
    ///
    /// # Errors
    /// [`Violation`] if the device must not send it.
    pub fn received(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        let node = u16::from(self.knowledge.node.raw());
        if self.blind {
            // The next start waits for the boot-up message of a device that is still starting, so this frame must be
            // noticed.
            if frame.cob_id() == Some(error_control::CAN_ID_BASE + node) {
                self.nmt.started(now, frame);
            }
            return Ok(());
        }
        self.expire(now)?;
        let state = self.state();
        self.judge(now, frame, coverage).map_err(|violation| violation.by(frame, state))
    }

    fn judge(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        let node = u16::from(self.knowledge.node.raw());
        let can_id = frame.id().as_standard().filter(|_| !frame.is_remote());
        match can_id {
            Some(id) if id == error_control::CAN_ID_BASE + node => return self.error_control_came(now, frame),
            Some(lss_wire::SLAVE_CAN_ID) if self.knowledge.services.lmt => {
                return self.lmt.answered(now, frame, coverage);
            }
            Some(lss_wire::SLAVE_CAN_ID) => return self.lss.answered(now, frame, coverage),
            _ => {}
        }
        self.nmt.passed(now);
        if can_id.is_some_and(|id| self.knowledge.bystanders.contains(&id)) {
            self.passed_by(now);
        } else {
            self.nmt.may_speak(now, frame, &self.knowledge)?;
        }
        match can_id {
            Some(id) if id == sdo_wire::RESPONSE_BASE + node => self.response_came(now, frame, coverage),
            Some(id) if self.expected_values.is_emcy(id, self.knowledge.node) => self.emcy_came(now, id, frame),
            Some(id) if self.expected_values.is_produced(id) => {
                self.pdo.shares(now, id, &self.expected_values, &self.knowledge);
                if self.expected_values.is_sync(id) {
                    self.pdo.synchronises_itself();
                }
                Ok(())
            }
            _ => {
                let judged = self.pdo.came(now, frame, &self.nmt, &self.expected_values, &self.knowledge);
                // The frame may be the first of a configuration that is not confirmed yet, or the last before a reset.
                if self.sdo.is_writing() || self.nmt.was_just_reset(now) { Ok(()) } else { judged }
            }
        }
    }

    /// Checks a boot-up message, a heartbeat or an answer to guarding.
    fn error_control_came(&mut self, now: Timestamp, frame: &Frame) -> Result<(), Violation> {
        if self.is_booting() {
            // An error may be reported after each start, even if the report of the start before has just come.
            self.emcy.reset();
        }
        let change = match self.nmt.shown(now, frame, &self.expected_values, &self.knowledge) {
            // The heartbeat may be the first with a period that is not confirmed yet.
            Err(_) if self.sdo.is_writing() => return Ok(()),
            judged => judged?,
        };
        if change == nmt::Change::State {
            self.doubt(now);
            self.sdo.booted(now, self.late());
            self.pdo.state_changed(now, &self.nmt);
        }
        Ok(())
    }

    fn response_came(&mut self, now: Timestamp, frame: &Frame, coverage: &mut Coverage) -> Result<(), Violation> {
        let served = self.nmt.serves_sdo();
        self.blind |= self.sdo.answered(now, frame, served, &self.knowledge, &mut self.expected_values, coverage)?;
        if self.sdo.is_sending_blocks() {
            // Block segments fill the bus and delay other frames.
            self.nmt.held_up(now);
            self.pdo.held_up(now);
        }
        // A write that the models can't follow may have changed the EMCY configuration, too.
        self.doubt(now);
        if let Some(change) = self.expected_values.take_change() {
            // A device that stops on an error does not report this state.
            self.blind |= change.0.index.0 == object::ERROR_BEHAVIOR && change.1 > 1;
            self.nmt.configured(now, change);
            self.pdo.configured(now, change);
        }
        Ok(())
    }

    fn emcy_came(&mut self, now: Timestamp, can_id: u16, frame: &Frame) -> Result<(), Violation> {
        // If a PDO has the identifier of EMCY, or is just being configured to it, PDO and EMCY can't be distinguished.
        let shares = self.pdo.shares(now, can_id, &self.expected_values, &self.knowledge);
        let judged = self.emcy.came(now, frame, &self.nmt);
        if !shares && !self.sdo.is_writing() {
            judged?;
        }
        if self.nmt.erred(now, frame, &self.expected_values, &self.knowledge) == nmt::Change::State {
            self.sdo.state_changed(now, self.nmt.serves_sdo(), self.late(), self.knowledge.patience.quiet);
            self.pdo.state_changed(now, &self.nmt);
        }
        Ok(())
    }

    /// Handles a frame of another node. Such frames without a pause between them delay the frames of the device.
    fn passed_by(&mut self, now: Timestamp) {
        if now.since(self.passed) < BURST {
            self.nmt.held_up(now);
            self.pdo.held_up(now);
        }
        self.passed = now;
    }

    /// The time at which the earliest outstanding answer is overdue; `None` if no answer is outstanding.
    pub fn due(&self) -> Option<Timestamp> {
        if self.blind {
            return None;
        }
        let due = [self.nmt.due(), self.sdo.due(), self.lss.at.due(), self.lmt.at.due(), self.pdo.due()];
        let earliest =
            due.into_iter().fold(Timestamp::MAX, |earliest, due| earliest.min(due.unwrap_or(Timestamp::MAX)));
        (earliest < Timestamp::MAX).then_some(earliest)
    }

    /// Checks whether an answer is overdue at `now`.
    ///
    /// # Errors
    /// [`Violation`] if an answer that was due has not come.
    pub fn expire(&mut self, now: Timestamp) -> Result<(), Violation> {
        if self.blind || self.due().is_none_or(|due| now < due) {
            return Ok(());
        }
        let (state, node) = (self.state(), u16::from(self.knowledge.node.raw()));
        let absent = |can_id: u16| move |violation: Violation| violation.by_absence(can_id, state);
        self.nmt.expire(now, &self.knowledge).map_err(absent(error_control::CAN_ID_BASE + node))?;
        self.sdo.expire(now).map_err(absent(sdo_wire::RESPONSE_BASE + node))?;
        self.lss.at.expire(now).map_err(absent(lss_wire::SLAVE_CAN_ID))?;
        self.lmt.at.expire(now).map_err(absent(lss_wire::SLAVE_CAN_ID))?;
        self.pdo.expire(now).map_err(|violation| Violation { state, ..violation })
    }

    /// The state of the device according to the models.
    pub fn state(&self) -> DeviceState {
        let lss = (self.knowledge.services.lss != Some(false)).then(|| self.lss.class());
        DeviceState {
            phase: Some(self.nmt.phase()),
            sdo: self.sdo.class(),
            lss: if self.knowledge.services.lmt { Some(self.lmt.at.class()) } else { lss },
        }
    }

    /// Whether the models know which answers must or must not follow the frame.
    pub fn judges(&self, frame: &Frame) -> bool {
        match frame.cob_id() {
            _ if self.blind => false,
            Some(id) if id == sdo_wire::REQUEST_BASE + u16::from(self.knowledge.node.raw()) => !self.sdo.is_open(),
            Some(lss_wire::MASTER_CAN_ID) => !self.lss.at.is_open() && !self.lmt.at.is_open(),
            _ => true,
        }
    }

    /// Whether the SDO server takes, or may take, the next frame for a segment of a block download.
    pub(crate) fn is_in_blocks(&self) -> bool {
        !self.blind && self.sdo.is_in_blocks()
    }

    /// Whether other answers may be under way in addition to the one that was due.
    pub fn is_open(&self) -> bool {
        !self.blind && self.sdo.is_open()
    }

    /// Whether the last frame has an optional answer of any service: the standard leaves open whether it comes.
    pub(crate) fn may_be_answered(&self) -> bool {
        !self.blind && (self.sdo.is_open() || self.lss.at.is_open() || self.lmt.at.is_open())
    }

    /// The rule of the answer that the SDO server owes now, if it owes one.
    pub(crate) fn awaits(&self) -> Option<&'static str> {
        if self.blind { None } else { self.sdo.awaits() }
    }

    /// Whether the SDO server would answer a request to read, and no transfer would be disturbed.
    pub(crate) fn may_be_asked(&self) -> bool {
        self.serves_sdo() && !self.sdo.is_busy() && !self.sdo.is_open()
    }

    /// Whether the state of the SDO server is unknown, and the answer to a request to read would tell it.
    pub fn is_lost(&self) -> bool {
        self.serves_sdo() && self.sdo.is_lost() && !self.lss.at.is_open() && !self.lmt.at.is_open()
    }

    /// Whether the device is in a known state from which the next sequence can begin: it runs, no transfer is under
    /// way, and neither node-ID nor bit rate has changed.
    pub fn is_at_rest(&self) -> bool {
        !self.blind
            && matches!(self.nmt.phase(), nmt::Phase::PreOperational | nmt::Phase::Operational | nmt::Phase::Running)
            && self.due().is_none()
            && !self.sdo.is_busy()
            && !self.sdo.is_open()
            && self.waits_for_lss()
            && !self.expected_values.bus_changed()
    }

    /// Whether the device can be brought to rest without a reset: it runs, and no change waits for a reset.
    pub fn may_go_on(&self) -> bool {
        let runs = !matches!(self.nmt.phase(), nmt::Phase::Unconfigured | nmt::Phase::Booting);
        let settled = self.lss.is_settled() || self.knowledge.services.lss == Some(false);
        !self.blind && runs && settled && !self.expected_values.bus_changed()
    }

    /// Continues with a device that was brought to pre-operational without a reset. No transfer is under way, LSS is in
    /// waiting state, and the objects have their power-on values. Everything else is unknown.
    pub fn go_on(&mut self, now: Timestamp) {
        self.expected_values.power_on(&self.knowledge);
        self.nmt.go_on(now);
        self.sdo.reset();
        self.lss.go_on();
        self.lmt.go_on();
        self.pdo.go_on(now);
        self.emcy.reset();
    }

    /// Whether the LSS or LMT slave is in waiting state, or does not exist.
    fn waits_for_lss(&self) -> bool {
        match &self.knowledge.services {
            services if services.lmt => self.lmt.at.is_at_rest(),
            services => services.lss == Some(false) || self.lss.is_at_rest(),
        }
    }

    /// The frames that bring the device to rest: commands whose effect is known in every state.
    pub(crate) fn brings_to_rest(&self) -> impl Iterator<Item = Frame> + use<> {
        let node = self.knowledge.node.raw();
        let is_lost = self.blind;
        let wait = lss_wire::Request::SwitchGlobal { mode: 0 }.to_frame(lss_wire::MASTER_CAN_ID);
        let wait = Some(wait).filter(|_| !is_lost && !self.waits_for_lss());
        let stands = matches!(self.nmt.phase(), nmt::Phase::Stopped | nmt::Phase::Unsure);
        let wake = nmt_wire::Nmt { command: nmt_wire::Command::ENTER_PRE_OPERATIONAL, node };
        let wake = Some(wake.to_frame(nmt_wire::CAN_ID)).filter(|_| !is_lost && stands);
        wait.into_iter().chain(wake)
    }

    /// Records that an object keeps this value, although the start should have restored another value.
    pub fn holds(&mut self, at: Multiplexer, value: u64) {
        self.expected_values.holds(&self.knowledge, at, value);
    }

    /// Handles the end of the required silence: no answer is under way any more.
    pub fn quiet(&mut self, now: Timestamp) {
        self.nmt.quiet();
        self.sdo.quiet();
        self.lss.at.quiet(now);
        self.lmt.at.quiet(now);
    }

    /// Checks at the end of a sequence the behaviour that can be judged only over time, such as periods.
    ///
    /// # Errors
    /// [`Violation`] if a periodic message was missing.
    pub fn finish(&mut self, now: Timestamp) -> Result<(), Violation> {
        if self.blind {
            return Ok(());
        }
        self.expire(now)?;
        if self.sdo.is_writing() {
            // A write under way may already have changed the periods.
            return Ok(());
        }
        let (state, node) = (self.state(), u16::from(self.knowledge.node.raw()));
        let id = error_control::CAN_ID_BASE + node;
        let heartbeats = self.nmt.finish(now, &self.expected_values, &self.knowledge);
        heartbeats.map_err(|violation| violation.by_absence(id, state))?;
        let pdos = self.pdo.finish(now, &self.nmt, &self.expected_values, &self.knowledge);
        pdos.map_err(|violation| Violation { state, ..violation })
    }

    /// Whether the device is between reset and boot-up, as far as is known.
    pub(crate) fn is_booting(&self) -> bool {
        self.nmt.phase() == nmt::Phase::Booting
    }

    /// Whether the SDO server has to answer requests now.
    pub(crate) fn serves_sdo(&self) -> bool {
        !self.blind && self.nmt.serves_sdo() == Served::Yes
    }
}

/// Whether a service works in the current state of the device.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Served {
    Yes,
    No,
    /// The model does not know the state.
    Unsure,
}

/// The violation by an answer that was due and has not come by `at`.
fn silence(property: Property, rule: &'static str, expected: impl Into<String>, at: Timestamp) -> Violation {
    Violation { is_silence: true, ..violation(property, rule, expected, "no answer", at) }
}

/// A violation at `at`.
fn violation(
    property: Property,
    rule: &'static str,
    expected: impl Into<String>,
    actual: impl Into<String>,
    at: Timestamp,
) -> Violation {
    Violation {
        property,
        rule,
        expected: expected.into().into_boxed_str(),
        actual: actual.into().into_boxed_str(),
        abort: None,
        interval: None,
        is_silence: false,
        symptom: Symptom::Missing(None),
        state: DeviceState::default(),
        at,
    }
}

#[cfg(test)]
mod tests;
