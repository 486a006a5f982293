//! Adapters of PEAK, through its own library PCAN-Basic: `PCANBasic.dll` on Windows, `libpcanbasic.so` on Linux.
//!
//! The library is loaded when such a bus is opened; nothing is needed to build. Frames have the adapter's own time stamps,
//! brought to the system's clock. Own frames are not given back by every adapter, so they have the time at which they were
//! handed over.

#[cfg(any(windows, target_os = "linux"))]
mod adapter;
mod channel;
mod error;
mod status;

#[cfg(any(windows, target_os = "linux"))]
pub use adapter::{Condition, Installed, Pcan, Present, installed};
pub use channel::Channel;
pub use error::PcanError;
pub use status::Status;

/// How a channel is opened.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Opening {
    /// Which.
    pub channel: Channel,
    /// In bit/s.
    pub bit_rate: u32,
    /// The controller acknowledges nothing and sends nothing.
    pub listen_only: bool,
}
