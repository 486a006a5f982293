//! The bus of a test, and the tester's side of the protocols. A case can't distinguish a live and a simulated bus.
//!
//! - [`Bus`]: the interface of every bus; [`SimulatedBus`], [`socketcan`], [`slcan`], [`pcan`] and [`network`] are
//!   buses;
//! - [`PatientBus`]: a bus that waits while it is interrupted;
//! - [`Machine`]: a participant of a bus without I/O and clock; [`participate`] connects a machine to a live bus;
//! - [`client`]: the state machines of an SDO client and an LSS master;
//! - [`observation`]: the behaviour of a device, as data;
//! - [`transcript`]: the data for repeating a run from its recording.

#![warn(clippy::disallowed_methods)]
#![allow(missing_docs, reason = "an internal crate: where the name says it all, there is no comment")]

pub mod client;
mod clock;
mod connection;
mod hardware_clock;
mod health;
mod inbox;
mod machine;
pub mod network;
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

    /// Queues a frame for sending. It is sent as soon as the bus is free and no lower identifier waits.
    ///
    /// # Errors
    /// [`BusError`] if the bus can't take the frame.
    fn send(&mut self, frame: &Frame) -> Result<(), BusError>;

    /// The next frame that was on the bus, or `None` if there was none until `deadline`; the time of a simulated bus is
    /// then `deadline`.
    ///
    /// Own frames are returned too, with the time at which they were sent and [`canvass_traces::Direction::Tx`]:
    /// evidence needs a record of the whole traffic.
    ///
    /// # Errors
    /// [`BusError`] if the bus fails.
    fn receive(&mut self, deadline: Timestamp) -> Result<Option<Record>, BusError>;

    /// The bit rate in bit/s, if it is known.
    fn bit_rate(&self) -> Option<u32>;

    /// Whether the time of the bus is real, not virtual.
    fn is_live(&self) -> bool {
        false
    }

    /// Waits for a client, at most for `patience`, if this is a bus to which another program must connect.
    ///
    /// # Errors
    /// [`BusError`] if no client has connected.
    fn wait_for_client(&mut self, patience: Duration) -> Result<(), BusError> {
        let _ = patience;
        Ok(())
    }

    /// Fills the unused bytes of sent frames with non-zero values from now on, like programs that don't clear
    /// `struct can_frame`: readers must ignore these bytes. Only SocketCAN has such bytes.
    fn dirty_padding(&mut self) {}

    /// The health of the bus. A simulated bus is always healthy.
    fn health(&self) -> Health {
        Health::default()
    }

    /// Whether the bus is interrupted now, so that it neither sends nor receives.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// Waits for the end of an interruption, if the bus is a [`PatientBus`].
    ///
    /// # Errors
    /// [`BusError::Interrupted`] if the bus does not come back in time.
    fn wait_until_back(&mut self) -> Result<(), BusError> {
        Ok(())
    }

    /// Limits the number of frames that wait for a slow reader; if there are more, the oldest are dropped.
    fn limit_backlog(&mut self, frames: usize) {
        let _ = frames;
    }

    /// Requests only frames with 11-bit identifiers that match one of these pairs of identifier and mask. A frame
    /// matches if its identifier equals that of the pair in the bits of the mask. The bus may deliver other frames all
    /// the same.
    ///
    /// # Errors
    /// [`BusError`] if the bus does not accept the filter.
    fn only(&mut self, cob_ids: &[(u16, u16)]) -> Result<(), BusError> {
        let _ = cob_ids;
        Ok(())
    }

    /// Changes the bit rate, in bit/s.
    ///
    /// # Errors
    /// [`BusError::FixedBitRate`] if this end of the bus can't change it.
    fn set_bit_rate(&mut self, bit_rate: u32) -> Result<(), BusError> {
        Err(BusError::FixedBitRate { bit_rate })
    }

    /// Changes the bit rate, in bit/s, and only listens: this end neither sends nor acknowledges frames, so that it
    /// disturbs nobody at a wrong bit rate. [`Bus::set_bit_rate`] ends that.
    ///
    /// # Errors
    /// [`BusError::NeverSilent`] if this end can't do that.
    fn listen_at(&mut self, bit_rate: u32) -> Result<(), BusError> {
        let _ = bit_rate;
        Err(BusError::NeverSilent)
    }
}

/// Why a bus does not work. The device under test is never the cause.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BusError {
    /// The address does not name a bus.
    #[error("{address}: {reason}")]
    Address {
        /// The address as typed.
        address: String,
        /// The error, and the expected form.
        reason: String,
    },
    /// The bus can't carry the frame.
    #[error("{frame} cannot be sent: {reason}")]
    Unsendable {
        frame: Frame,
        /// The frames that the bus can carry.
        reason: &'static str,
    },
    /// This end of the bus can't change the bit rate.
    #[error("the bit rate of this bus is set outside of the program: change it to {bit_rate} bit/s there")]
    FixedBitRate {
        /// The requested bit rate in bit/s.
        bit_rate: u32,
    },
    /// This end of the bus can't only listen.
    #[error(
        "this end of the bus can't listen without acknowledging frames: use an adapter with SLCAN, one of PEAK, or \
         SocketCAN with the right to configure interfaces"
    )]
    NeverSilent,
    /// This build lacks the interface.
    #[error("{address}: {interface} is not available in this build")]
    Unavailable {
        /// The address as typed.
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
    /// The bus over a network does not work.
    #[error(transparent)]
    Network(#[from] network::NetworkError),
    /// The adapter of PEAK does not work.
    #[error(transparent)]
    Pcan(#[from] pcan::PcanError),
    /// The bus was interrupted and did not come back in time.
    #[error("{trouble}; the bus was not back within {waited}")]
    Interrupted {
        /// The cause of the interruption.
        trouble: String,
        /// The time waited.
        waited: Duration,
    },
    /// The tester diverges from the recording.
    #[error("the recording diverges {0}")]
    Replay(#[from] transcript::Divergence),
    /// The operating system reports an error.
    #[error("the bus failed: {0}")]
    Io(#[from] std::io::Error),
}

impl BusError {
    /// Whether the error ends when the interruption of the bus ends.
    pub const fn is_interruption(&self) -> bool {
        match self {
            #[cfg(target_os = "linux")]
            Self::SocketCan(error) => error.is_interruption(),
            Self::SlCan(error) => {
                matches!(error, slcan::SlCanError::NotConnected { .. } | slcan::SlCanError::Nobody { .. })
            }
            Self::Pcan(error) => matches!(error, pcan::PcanError::Failed { .. } | pcan::PcanError::QueueFull { .. }),
            Self::Network(error) => matches!(error, network::NetworkError::NotConnected { .. }),
            Self::Interrupted { .. } => true,
            _ => false,
        }
    }

    /// Whether the transmit queue stayed full, because no node acknowledges or the bus is too busy.
    pub const fn is_full(&self) -> bool {
        match self {
            #[cfg(target_os = "linux")]
            Self::SocketCan(socketcan::SocketCanError::QueueFull { .. }) => true,
            Self::Pcan(pcan::PcanError::QueueFull { .. }) => true,
            _ => false,
        }
    }
}
