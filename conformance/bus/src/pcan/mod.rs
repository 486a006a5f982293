//! Adapters of PEAK, through its own library PCAN-Basic: `PCANBasic.dll` on Windows, `libpcanbasic.so` on Linux.
//!
//! The library is loaded when such a bus is opened, so canvass builds without it. Frames have the adapter's time
//! stamps, converted to the system's clock. Not every adapter echoes own frames; so own frames get the time of sending.

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

/// Parameters for opening a channel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Opening {
    /// The channel.
    pub channel: Channel,
    /// The bit rate in bit/s.
    pub bit_rate: u32,
    /// Whether the controller only listens: it neither acknowledges nor sends.
    pub listen_only: bool,
}
