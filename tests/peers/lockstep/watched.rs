//! The bus of a run, which counts every frame, and interrupts the run or keeps its state at chosen frames.

use super::world::State;
use canvass_bus::{Bus, BusError, SimulatedBus};
use canvass_traces::{Direction, Frame, Record, Timestamp};
use std::cell::{Cell, RefCell};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// The frames, counted from 1, at which the run is interrupted or its state kept.
#[derive(Default)]
pub struct Moments {
    pub interrupt: Option<u64>,
    pub kill: Vec<u64>,
    /// The path of the run's journal.
    pub journal: PathBuf,
    /// The file that requests to switch the supply off and on.
    pub switch: PathBuf,
    pub cancel: AtomicBool,
}

/// The frames on the bus so far.
#[derive(Default)]
pub struct Seen {
    pub frames: Cell<u64>,
    /// The frames of the tester.
    pub sent: RefCell<Vec<Frame>>,
    /// The state that a kill would leave, with the number of the frame.
    pub kills: RefCell<Vec<(u64, State)>>,
}

/// The bus of a run.
pub struct Watched<'a> {
    pub bus: &'a mut SimulatedBus,
    pub moments: &'a Moments,
    pub seen: &'a Seen,
}

impl Watched<'_> {
    /// Switches the supply on request. The tester's command for the supply has ended before the tester uses the bus
    /// again.
    fn obey_switch(&mut self) {
        if self.moments.switch.exists() && std::fs::remove_file(&self.moments.switch).is_ok() {
            self.bus.power_cycle(0);
        }
    }

    fn count(&self, record: &Record) {
        let frame = self.seen.frames.get() + 1;
        self.seen.frames.set(frame);
        if record.direction == Direction::Tx {
            self.seen.sent.borrow_mut().push(record.frame);
        }
        if self.moments.interrupt == Some(frame) {
            self.moments.cancel.store(true, Ordering::Relaxed);
        }
        if self.moments.kill.contains(&frame)
            && let Some(bus) = self.bus.duplicate()
        {
            // The killed tester never learns of this frame: only the journal up to now is left.
            let journal = std::fs::read_to_string(&self.moments.journal).ok();
            self.seen.kills.borrow_mut().push((frame, State { bus, journal }));
        }
    }
}

impl Bus for Watched<'_> {
    fn now(&self) -> Timestamp {
        self.bus.now()
    }

    fn send(&mut self, frame: &Frame) -> Result<(), BusError> {
        self.obey_switch();
        self.bus.send(frame)
    }

    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError> {
        self.obey_switch();
        let record = self.bus.receive(deadline)?;
        record.iter().for_each(|record| self.count(record));
        Ok(record)
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bus.bit_rate()
    }

    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        self.bus.set_bit_rate(bit_rate)
    }
}
