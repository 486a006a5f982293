//! The bus that a test runs on: live or simulated, a case can't tell which; and the tester's side of the protocols.
//!
//! - [`Bus`]: what every bus can do; [`SimulatedBus`], [`socketcan`], [`slcan`] and [`pcan`] are buses;
//! - [`PatientBus`]: a bus that is waited for while the way to it is interrupted;
//! - [`Machine`]: what takes part in a bus without I/O and clock of its own; [`participate`] lets it do so;
//! - [`client`]: the state machines of an SDO client and an LSS master;
//! - [`observation`]: what a device did, as data;
//! - [`transcript`]: a run that can be done again on its recording.

#![warn(clippy::disallowed_methods)]
#![allow(missing_docs, reason = "an internal crate: where the name says it all, there is no comment")]

pub mod client;
mod clock;
mod hardware_clock;
mod health;
mod inbox;
mod machine;
pub mod observation;
mod participant;
mod patient;
pub mod pcan;
mod processor_wait;
mod simulated;
pub mod slcan;
#[cfg(target_os = "linux")]
pub mod socketcan;
pub mod transcript;

pub use health::{Health, Interruptions, Latencies, StampTrouble};
pub use machine::Machine;
pub use participant::{Participation, participate};
pub use patient::{Endurance, PatientBus};
pub use simulated::SimulatedBus;

use canvass_traces::{Duration, Frame, Record, Timestamp};

/// A CAN bus with its clock.
pub trait Bus {
    /// The time on this bus.
    fn now(&self) -> Timestamp;

    /// Hands over a frame for sending. It goes out as soon as the bus is free and no lower identifier wants it.
    ///
    /// # Errors
    /// [`BusError`] if the bus can't take it.
    fn send(&mut self, frame: &Frame) -> Result<(), BusError>;

    /// The next frame that was on the bus, or `None` if there was none until `deadline`; on the simulated bus
    /// the time is then `deadline`.
    ///
    /// Own frames come back too, with the time at which they were sent and [`canvass_traces::Direction::Tx`]: a
    /// record of the whole traffic is what evidence is made of.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError>;

    /// The bit rate in bit/s, where it is known.
    fn bit_rate(&self) -> Option<u32>;

    /// Whether time goes by on it as it does for people.
    fn is_live(&self) -> bool {
        false
    }

    /// Where somebody has to connect to this end first: waits for that, at most so long.
    ///
    /// # Errors
    /// [`BusError`] if nobody has connected.
    fn wait_for_client(&mut self, patience: Duration) -> Result<(), BusError> {
        let _ = patience;
        Ok(())
    }

    /// From now on those bytes of the frames that are handed over that carry nothing are not zero, as of programs that
    /// don't clear `struct can_frame`: readers must not look at them. Only SocketCAN has such bytes.
    fn dirty_padding(&mut self) {}

    /// How well it works. A simulated bus always works well.
    fn health(&self) -> Health {
        Health::default()
    }

    /// Whether the way to it is interrupted now: nothing can be sent, and nothing comes, until it is back.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// Waits while the way to it is interrupted, where it is waited for: see [`PatientBus`].
    ///
    /// # Errors
    /// [`BusError::Interrupted`] if it does not come back in time.
    fn wait_until_back(&mut self) -> Result<(), BusError> {
        Ok(())
    }

    /// Limits how many frames wait for a slow reader: beyond that number the oldest are lost.
    fn limit_backlog(&mut self, frames: usize) {
        let _ = frames;
    }

    /// Says that only frames of 11 bits are wanted whose identifier equals one of these where its mask has ones, so
    /// that the others need not be fetched. More may come all the same.
    ///
    /// # Errors
    /// [`BusError`] if the bus does not take it.
    fn only(&mut self, cob_ids: &[(u16, u16)]) -> Result<(), BusError> {
        let _ = cob_ids;
        Ok(())
    }

    /// Goes on at another bit rate in bit/s.
    ///
    /// # Errors
    /// [`BusError::FixedBitRate`] where this end of the bus can't change it.
    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        Err(BusError::FixedBitRate { bit_rate })
    }
}

/// Why a bus does not work. Never the fault of the device under test.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BusError {
    /// The address does not name a bus.
    #[error("{address}: {reason}")]
    Address {
        /// As it was given.
        address: String,
        /// What is wrong and what would be right.
        reason: String,
    },
    /// The bus cannot carry that frame.
    #[error("{frame} cannot be sent: {reason}")]
    Unsendable {
        frame: Frame,
        /// What the bus can carry.
        reason: &'static str,
    },
    /// The bit rate can't be changed from here.
    #[error("the bit rate of this bus is set outside of the program: change it to {bit_rate} bit/s there")]
    FixedBitRate {
        /// What was asked for, in bit/s.
        bit_rate: u32,
    },
    /// This build of the program has no such interface.
    #[error("{address}: {interface} is not available in this build")]
    Unavailable {
        /// As it was given.
        address: String,
        /// The kind of interface.
        interface: &'static str,
    },
    /// SocketCAN does not work.
    #[cfg(target_os = "linux")]
    #[error(transparent)]
    SocketCan(#[from] socketcan::SocketCanError),
    /// The SLCAN adapter does not work.
    #[error(transparent)]
    SlCan(#[from] slcan::SlCanError),
    /// The adapter of PEAK does not work.
    #[error(transparent)]
    Pcan(#[from] pcan::PcanError),
    /// The way to the bus was interrupted, and was not back in time.
    #[error("{trouble}; the bus was not back within {waited}")]
    Interrupted {
        /// What the interruption was.
        trouble: String,
        /// How long it was waited for.
        waited: Duration,
    },
    /// A recording does not go on as the tester does.
    #[error("the recording goes another way {0}")]
    Replay(#[from] transcript::Divergence),
    /// The operating system reports an error.
    #[error("the bus failed: {0}")]
    Io(#[from] std::io::Error),
}

impl BusError {
    /// Whether it lasts until the way to the bus is back, and no longer.
    pub const fn is_interruption(&self) -> bool {
        match self {
            #[cfg(target_os = "linux")]
            Self::SocketCan(error) => error.is_interruption(),
            Self::SlCan(error) => matches!(error, slcan::SlCanError::NotConnected { .. }),
            Self::Pcan(error) => matches!(error, pcan::PcanError::Failed { .. } | pcan::PcanError::QueueFull { .. }),
            Self::Interrupted { .. } => true,
            _ => false,
        }
    }

    /// Whether the transmit queue was full all the time: nobody has acknowledged, or the bus had no room.
    pub const fn is_full(&self) -> bool {
        match self {
            #[cfg(target_os = "linux")]
            Self::SocketCan(socketcan::SocketCanError::QueueFull { .. }) => true,
            Self::Pcan(pcan::PcanError::QueueFull { .. }) => true,
            _ => false,
        }
    }
}
