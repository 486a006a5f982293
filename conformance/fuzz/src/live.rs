//! A live device, which is reset at the start of a sequence.

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

/// A live device on its bus.
pub struct Live<'a> {
    bus: &'a mut dyn Bus,
    node: NodeId,
    patience: Patience,
    boot_up_message: bool,
    /// Duration of the last start; `None` before the first.
    restart: Option<Duration>,
    time: TimeLimit,
}

/// Number of resets without a sign of life after which the device counts as dead.
const RESETS: u32 = 3;

/// Boot time that the first reset allows to a device that answered before this reset, while its real boot time is not
/// known.
const FIRST_BOOT: Duration = Duration::from_secs(15);

/// Time to wait for a boot-up message before the device is asked for an answer. Both steps are repeated.
const SOON: Duration = Duration::from_secs(1);

impl<'a> Live<'a> {
    /// Resets the device that `knowledge` describes.
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

    /// Resets the device. Returns whether it comes back.
    fn reset(&mut self, boot: Duration) -> Result<bool, BusError> {
        let reset = Nmt { command: Command::RESET_NODE, node: self.node.raw() };
        let begun = self.bus.now();
        self.bus.send(&reset.to_frame(nmt::CAN_ID))?;
        if !self.boot_up_message {
            self.drain(self.patience.quiet)?;
        }
        // An answer is the sign of life if the device sends no boot-up message.
        loop {
            let soon = SOON.max(self.patience.quiet).min(boot);
            if self.boot_up_message && wait_for_boot_up(self.bus, self.node, soon)? || self.is_alive()? {
                self.restart = Some(self.bus.now().since(begun));
                return Ok(true);
            }
            // This wait does not end with the run's time: a device that is still starting is not dead.
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
                // Late answers to earlier requests come within the time of the slowest answer.
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
