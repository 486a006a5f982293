//! After a violation the fuzzer goes on without a reset if the device's own answers show its state and values.

use super::{Cause, Executor, Pace, Stop, WEDGED};
use crate::baseline;
use crate::oracle::{Symptom, Violation};
use crate::property::Property;
use crate::stand::TestStand;
use crate::stimulus::Stimulus;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_bus::BusError;
use canvass_traces::{Direction, Duration};

impl Executor {
    /// Whether a sequence continues after a violation that was reported before. The rest of the sequence may show more.
    pub(super) fn is_tolerated(&self, stand: &dyn TestStand, violation: &Violation) -> bool {
        self.waits.pace == Pace::Swift
            && !stand.is_repeatable()
            && self.known.is_reported(violation)
            && self.is_alive_after(violation)
    }

    /// Whether the fuzzer may continue without a reset in the state that a sequence has left, once the answers of the
    /// device show this state. No change may wait for a reset, and the device must be neither starting nor without
    /// node-ID.
    pub(super) fn may_recover(&self, ended: &Result<(), Stop>) -> bool {
        match ended {
            Ok(()) => self.oracle.may_go_on(),
            Err(Stop::Violation(violation)) => self.is_alive_after(violation),
            Err(_) => false,
        }
    }

    /// Whether the device still answers despite the violation, and may go on.
    fn is_alive_after(&self, violation: &Violation) -> bool {
        let is_of_lss = matches!(violation.property, Property::LegalLss | Property::Fastscan);
        let is_alive = violation.property != Property::Alive && (!violation.is_silence || is_of_lss);
        is_alive && self.oracle.may_go_on()
    }

    /// Whether recoveries have taken less time on average than resets.
    pub(super) fn is_recovery_faster(&self) -> bool {
        let usual = |cause| match self.tally.spent.of(cause) {
            (0, _) => None,
            (count, time) => Some(time.nanos() / count),
        };
        match (usual(Cause::Recovery), usual(Cause::Start)) {
            (Some(recovery), Some(start)) => recovery <= start,
            _ => true,
        }
    }

    /// Ends any transfer, reads the objects that may have changed, and writes the power-on values back. `false`: the
    /// device does not answer like a device at rest.
    pub(super) fn recover(&mut self, stand: &mut dyn TestStand) -> Result<bool, Stop> {
        let begun = stand.bus().now();
        let recovered = self.bring_to_rest(stand);
        self.waits.outstanding = 0;
        self.tally.spent.add(Cause::Recovery, stand.bus().now().since(begun));
        recovered
    }

    fn bring_to_rest(&mut self, stand: &mut dyn TestStand) -> Result<bool, Stop> {
        let node = self.knowledge.node.raw();
        let rest = Nmt { command: Command::ENTER_PRE_OPERATIONAL, node }.to_frame(nmt::CAN_ID);
        for frame in [rest, self.requests.abort] {
            self.hand_over(stand, frame)?;
        }
        // Late answers come within the time of silence.
        self.drain(stand, self.waits.quiet())?;
        if !self.is_idle(stand)? {
            return Ok(false);
        }
        let (unsettled, history) = (self.history.unsettled().to_vec(), &mut self.history);
        let kept = baseline::restore(stand.bus(), &unsettled, &[], &self.knowledge, &mut |record| {
            if record.direction == Direction::Tx {
                history.send(Stimulus::settle(record.frame));
            }
            history.note(record.clone());
        })?;
        self.history.settle();
        self.condition.kept.retain(|before| kept.iter().all(|now| now.at != before.at));
        self.condition.kept.extend(kept);
        self.waits.trusts.awaits_lss = false;
        self.oracle.go_on(stand.bus().now());
        for kept in &self.condition.kept {
            self.oracle.holds(kept.at, kept.value);
        }
        Ok(true)
    }

    /// Whether reading 1000h succeeds as on a server without a transfer. A missing answer is a violation (PROP-01); the
    /// fuzzer waits the full time for it only if the violation is new.
    fn is_idle(&mut self, stand: &mut dyn TestStand) -> Result<bool, Stop> {
        self.hand_over(stand, self.requests.probe)?;
        let is_news = self.known.is_wedged_news();
        let within = if is_news { self.knowledge.patience.answer } else { self.waits.missing_after() };
        let until = stand.bus().now() + within;
        while let Some(record) = stand.bus().receive(until)? {
            let frame = record.frame;
            self.history.note(record);
            if frame.cob_id() == Some(self.requests.response) {
                return Ok(self.requests.is_value(&frame, Multiplexer::new(object::DEVICE_TYPE, 0)));
            }
        }
        if !is_news {
            return Ok(false);
        }
        Err(Stop::Violation(Violation {
            property: WEDGED.0,
            rule: WEDGED.1,
            expected: format!("the value of 1000h within {within}, after an abort in pre-operational").into(),
            actual: "no answer".into(),
            abort: None,
            interval: None,
            is_silence: true,
            symptom: Symptom::Missing(Some(self.requests.response)),
            state: self.oracle.state(),
            at: stand.bus().now(),
        }))
    }

    fn drain(&mut self, stand: &mut dyn TestStand, time: Duration) -> Result<(), BusError> {
        let until = stand.bus().now() + time;
        while let Some(record) = stand.bus().receive(until)? {
            self.history.note(record);
        }
        Ok(())
    }
}
