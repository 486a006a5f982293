//! NMT commands, resets and boot-up.

use super::watch::SAME_START;
use super::{Bench, Sent};
use crate::verdict::{Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control::{self, ErrorControl, State};
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_traces::{Duration, Frame, Record, Timestamp};

/// Wait after a boot-up: pending EMCYs and first heartbeats come now, not in the middle of the case.
const AFTER_BOOT_UP: Duration = Duration::from_millis(50);

/// Wait between two NMT commands: some stacks keep only one pending command.
const BETWEEN_COMMANDS: Duration = Duration::from_millis(20);

/// Wait after the reset of a device without boot-up message: before its restart it may still answer.
const SILENT_START: Duration = Duration::from_millis(1_000);

/// The frames of the device between a reset command and the end of its start.
#[derive(Clone, Debug, Default)]
pub struct Start {
    /// All error control messages with state 0, of any length.
    pub boot_ups: Vec<Record>,
    /// The frames of the device before the first boot-up message.
    pub before: Vec<Record>,
}

impl Bench<'_> {
    /// Sends an NMT command to the device under test.
    ///
    /// # Errors
    /// The errors of [`Bench::send`].
    pub fn command(&mut self, command: Command) -> Result<Sent, Stop> {
        self.command_to(self.node().raw(), command)
    }

    /// Sends an NMT command to all nodes.
    ///
    /// # Errors
    /// The errors of [`Bench::send`].
    pub(crate) fn command_all(&mut self, command: Command) -> Result<Sent, Stop> {
        self.command_to(0, command)
    }

    /// Sends an NMT command with any node-ID byte, even a reserved one.
    ///
    /// # Errors
    /// The errors of [`Bench::send`].
    pub(crate) fn command_to(&mut self, node: u8, command: Command) -> Result<Sent, Stop> {
        let concerned = node == 0 || node == self.node().raw();
        if concerned && command.is_reset() {
            self.traffic.watch.expect_boot_up();
        }
        if concerned && command == Command::START {
            self.traffic.watch.start();
        }
        self.send(&Nmt { command, node }.to_frame(nmt::CAN_ID))
    }

    /// Declares that the device may restart because of the next action of the case: a restart is no surprise, but not
    /// required either.
    pub(crate) fn watch_restart(&mut self) {
        self.traffic.watch.expect_boot_up();
    }

    /// Whether a frame is a correct boot-up message of the device under test: one byte, 00h.
    pub fn is_boot_up(&self, frame: &Frame) -> bool {
        self.is_error_control(frame) && frame.data() == [0]
    }

    /// Whether a frame is an error control message of the device under test, with any content.
    pub(crate) fn is_error_control(&self, frame: &Frame) -> bool {
        frame.cob_id() == Some(error_control::CAN_ID_BASE + u16::from(self.node().raw()))
    }

    /// Waits for the boot-up message; `None` if it does not come in time.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub fn wait_for_boot_up(&mut self) -> Result<Option<Timestamp>, Stop> {
        self.wait_for_boot_up_within(self.timing().boot_up)
    }

    fn wait_for_boot_up_within(&mut self, span: Duration) -> Result<Option<Timestamp>, Stop> {
        let boot_up = error_control::CAN_ID_BASE + u16::from(self.node().raw());
        self.wait_for(span, |record| {
            let is_boot_up = record.frame.cob_id() == Some(boot_up)
                && ErrorControl::read(record.frame.data()).is_ok_and(ErrorControl::is_boot_up);
            is_boot_up.then_some(record.timestamp)
        })
    }

    /// Resets the device and waits for its start. A device that sends no boot-up message but answers SDOs again counts
    /// as started: only the cases on boot-up judge the missing message.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device does not come back.
    pub fn reset(&mut self, command: Command) -> Result<(), Stop> {
        self.drain()?;
        self.command(command)?;
        if !self.has_started()? {
            // Some devices ignore resets in stopped.
            self.command(Command::ENTER_PRE_OPERATIONAL)?;
            self.listen(BETWEEN_COMMANDS)?;
            self.command(command)?;
            if !self.has_started()? {
                if !self.answers()? {
                    let (duty, expected) = (format!("after {command} the device starts"), "a boot-up message");
                    return Err(Stop::Inconclusive(Reason::new(duty, expected, "neither boot-up nor SDO response")));
                }
                self.knowledge.starts_silently = true;
            }
        }
        self.listen(AFTER_BOOT_UP)?;
        Ok(())
    }

    /// Whether the device has started, as its boot-up message shows. A device that is known to send none has started
    /// when it answers again: waiting for the message would take the longest time of a start at each reset.
    fn has_started(&mut self) -> Result<bool, Stop> {
        if !self.knowledge.starts_silently {
            return Ok(self.wait_for_boot_up()?.is_some());
        }
        let deadline = self.now() + self.timing().boot_up;
        if self.wait_for_boot_up_within(SILENT_START)?.is_some() {
            self.knowledge.starts_silently = false;
            return Ok(true);
        }
        while self.now() < deadline {
            if self.answers()? {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Resets the device and records its start: from the command until `after` has passed since the first boot-up, or
    /// until the boot-up time has passed without one.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub(crate) fn record_start(&mut self, command: Command, after: Duration) -> Result<Start, Stop> {
        self.drain()?;
        self.command(command)?;
        // The command itself must be on the bus first: frames before it do not belong to the start.
        self.wait_for_own(nmt::CAN_ID)?;
        let deadline = self.now() + self.timing().boot_up;
        let mut start = Start::default();
        while start.boot_ups.is_empty() && self.now() < deadline {
            let remaining = deadline.since(self.now());
            self.record_until_boot_up(remaining, &mut start)?;
        }
        if !start.boot_ups.is_empty() {
            let more = self.listen(after)?;
            start.boot_ups.extend(more.into_iter().filter(|record| self.is_state_zero(&record.frame)));
        }
        Ok(start)
    }

    /// Whether each start of the device has a second boot-up message, for example one of a bootloader. One more reset
    /// finds this out, once in a run. If the device does not start, nothing is proved.
    pub(crate) fn boots_twice(&mut self) -> bool {
        if let Some(known) = self.knowledge.boots_twice {
            return known;
        }
        let start = self.uncancelled(|bench| bench.record_start(Command::RESET_NODE, SAME_START));
        let found = start.ok().map(|start| start.boot_ups.len()).filter(|&boot_ups| boot_ups > 0);
        self.knowledge.boots_twice = found.map(|boot_ups| boot_ups > 1);
        self.knowledge.boots_twice.unwrap_or(true)
    }

    fn record_until_boot_up(&mut self, span: Duration, start: &mut Start) -> Result<(), Stop> {
        let node = self.node();
        let error_control = error_control::CAN_ID_BASE + u16::from(node.raw());
        let boot_up = self.wait_for(span, |record| {
            if !super::traffic::is_from(node, &record.frame) {
                return None;
            }
            if record.frame.cob_id() == Some(error_control) && is_state_zero(&record.frame) {
                return Some(record.clone());
            }
            start.before.push(record.clone());
            None
        })?;
        start.boot_ups.extend(boot_up);
        Ok(())
    }

    fn is_state_zero(&self, frame: &Frame) -> bool {
        self.is_error_control(frame) && is_state_zero(frame)
    }

    /// Waits until an own frame with this CAN-ID was on the bus.
    fn wait_for_own(&mut self, cob_id: u16) -> Result<(), Stop> {
        let deadline = self.now() + self.timing().reaction;
        while let Some(record) = self.traffic.receive(deadline)? {
            let is_own = record.direction == canvass_traces::Direction::Tx;
            // If own frames do not come back, a bus with much traffic must not prolong the wait.
            if is_own && record.frame.cob_id() == Some(cob_id) || record.timestamp > deadline {
                break;
            }
        }
        Ok(())
    }

    /// Whether the SDO server answers at all.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub fn answers(&mut self) -> Result<bool, Stop> {
        Ok(!self.upload(Multiplexer::new(object::DEVICE_TYPE, 0))?.is_silent())
    }

    /// Establishes the state in which every case starts: reset, boot-up seen, pre-operational even if the device starts
    /// by itself.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device does not reach this state.
    pub fn prepare(&mut self) -> Result<(), Stop> {
        self.reset(Command::RESET_NODE)?;
        if self.unjudged(Self::starts_by_itself)? {
            self.command(Command::ENTER_PRE_OPERATIONAL)?;
            self.listen(self.timing().reaction)?;
        }
        Ok(())
    }

    /// Whether the device becomes operational after a reset without a command: 1F80h or an object of the manufacturer
    /// can cause that. A device that does not show its state counts as such a device. One more reset finds this out,
    /// once in a run.
    pub(crate) fn starts_by_itself(&mut self) -> Result<bool, Stop> {
        if let Some(known) = self.knowledge.starts_by_itself {
            return Ok(known);
        }
        if !self.answers()? && self.answers_in_pre_operational()? {
            // The server is silent, which only stopped allows. SDO can't show whether this device started itself.
            self.knowledge.starts_by_itself = Some(true);
            return Ok(true);
        }
        let found = match self.show_state() {
            Err(Stop::Inconclusive(_) | Stop::Breach(_)) if !self.is_cancelled() => true,
            shown => {
                shown?;
                self.state()? != Some(State::PRE_OPERATIONAL)
            }
        };
        self.knowledge.starts_by_itself = Some(found);
        // A firmware that keeps values over a reset must not keep this heartbeat time.
        self.restore();
        self.reset(Command::RESET_NODE)?;
        Ok(found)
    }

    fn answers_in_pre_operational(&mut self) -> Result<bool, Stop> {
        self.command(Command::ENTER_PRE_OPERATIONAL)?;
        self.listen(self.timing().reaction)?;
        self.answers()
    }
}

fn is_state_zero(frame: &Frame) -> bool {
    ErrorControl::read(frame.data()).is_ok_and(ErrorControl::is_boot_up)
}
