//! A device on a bus that goes on: it is reset where a sequence has to begin anew.

use super::learn::ask;
use super::stand::{Readiness, TestStand, wait_for_boot_up};
use super::time_limit::TimeLimit;
use super::{Knowledge, Patience, Start};
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::{self, Command, Nmt};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, BusError};
use canvass_traces::Duration;

/// A device on a bus that goes on.
pub struct Live<'a> {
    bus: &'a mut dyn Bus,
    node: NodeId,
    patience: Patience,
    boot_up_message: bool,
    /// How long the last start took; `None`: there was none.
    restart: Option<Duration>,
    time: TimeLimit,
}

/// Number of resets of a device without a sign of life before it is given up.
const RESETS: u32 = 3;

/// A device that was alive before its first reset is given that time to come back: nobody knows yet how long it takes.
const FIRST_BOOT: Duration = Duration::from_secs(15);

/// A boot-up message is waited for this long before an answer is asked for, again and again.
const SOON: Duration = Duration::from_secs(1);

impl<'a> Live<'a> {
    /// The device that `knowledge` is about.
    pub fn new(bus: &'a mut dyn Bus, knowledge: &Knowledge) -> Self {
        let boot_up_message = knowledge.services.boot_up_message;
        Self {
            bus,
            node: knowledge.node,
            patience: knowledge.patience,
            boot_up_message,
            restart: None,
            time: TimeLimit::default(),
        }
    }

    /// Limits the resets: after this time, a device without a sign of life is reset only once.
    #[must_use]
    pub fn until(self, time: TimeLimit) -> Self {
        Self { time, ..self }
    }

    fn is_alive(&mut self) -> Result<bool, BusError> {
        Ok(ask(self.bus, self.node, self.patience.answer, Multiplexer::new(object::DEVICE_TYPE, 0))?.is_some())
    }

    /// Whether the device comes back from a reset.
    fn reset(&mut self, boot: Duration) -> Result<bool, BusError> {
        let reset = Nmt { command: Command::RESET_NODE, node: self.node.raw() };
        let begun = self.bus.now();
        self.bus.send(&reset.to_frame(nmt::CAN_ID))?;
        if !self.boot_up_message {
            self.drain(self.patience.quiet)?;
        }
        // Where there is no boot-up message, or it does not come, an answer is the sign of life.
        loop {
            let soon = SOON.max(self.patience.quiet).min(boot);
            if self.boot_up_message && wait_for_boot_up(self.bus, self.node, soon)? || self.is_alive()? {
                self.restart = Some(self.bus.now().since(begun));
                return Ok(true);
            }
            // Also where the run's time is over: a device that is still starting is not dead.
            if self.bus.now() >= begun + boot {
                return Ok(false);
            }
        }
    }

    fn drain(&mut self, time: Duration) -> Result<(), BusError> {
        let until = self.bus.now() + time;
        while self.bus.receive(until)?.is_some() {}
        Ok(())
    }
}

impl TestStand for Live<'_> {
    fn begin(&mut self, _: Start) -> Result<Readiness, BusError> {
        let is_first = self.restart.is_none();
        let boot = if is_first && self.is_alive()? { FIRST_BOOT } else { self.patience.boot };
        for attempt in 0..RESETS {
            if self.reset(boot)? {
                // Late answers to requests of the time before come within the time of the slowest answer.
                self.drain(self.patience.quiet)?;
                return Ok(if attempt == 0 || is_first { Readiness::Ready } else { Readiness::Revived });
            }
            if self.time.is_over() {
                break;
            }
        }
        Ok(Readiness::Dead)
    }

    fn bus(&mut self) -> &mut dyn Bus {
        self.bus
    }

    fn has_unconfigured(&self) -> bool {
        false
    }

    fn is_repeatable(&self) -> bool {
        false
    }

    fn restart_time(&self) -> Duration {
        self.restart.unwrap_or_default()
    }

    fn attune(&mut self, patience: Patience) {
        self.patience = patience;
    }
}
