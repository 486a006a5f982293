//! The bus that a test runs on: live or simulated, a case can't tell which.

mod address;
mod simulated;
mod simulated_address;

pub use address::{BusAddress, Opened, open, open_seeded};
pub use simulated::SimulatedBus;
pub use simulated_address::{Attached, DeviceName, GivenNode, SimulatedDevice};

use canvass_traces::{Frame, Record, Timestamp};

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
        /// The frame.
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
    /// The operating system reports an error.
    #[error("the bus failed: {0}")]
    Io(#[from] std::io::Error),
}
