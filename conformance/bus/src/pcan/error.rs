//! The reasons why an adapter of PEAK does not work, with remedies.

use super::channel::Channel;
use super::status::Status;
use canvass_traces::Duration;

/// Why an adapter of PEAK does not work. The text of each error includes the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PcanError {
    /// PEAK's library is missing.
    #[error("can't load {name}, PEAK's library ({reason}): {}", Self::library_remedy())]
    NoLibrary {
        /// The file name of the library.
        name: String,
        /// The system's error.
        reason: String,
    },
    /// The library lacks a function.
    #[error("{name} has no {function} ({reason}): install the current version of PCAN-Basic")]
    OldLibrary {
        /// The file name of the library.
        name: String,
        /// The missing function.
        function: &'static str,
        /// The system's error.
        reason: String,
    },
    /// PCAN-Basic has no registers for the bit rate.
    #[error(
        "PCAN-Basic has no bit rate of {0} bit/s: expected one of 5k, 10k, 20k, 33333, 47619, 50k, 83333, 95238, 100k, \
         125k, 250k, 500k, 800k, 1M"
    )]
    BitRate(u32),
    /// A function of the library fails.
    #[error("can't {action} {channel}: {status}")]
    Failed {
        channel: Channel,
        /// The failed action.
        action: &'static str,
        /// The library's status.
        status: Status,
    },
    /// The transmit queue stays full.
    #[error("{channel} has sent nothing for {waited}: no node acknowledges, or the bus is full ({status})")]
    QueueFull {
        channel: Channel,
        /// The time waited.
        waited: Duration,
        /// The status of the bus.
        status: Status,
    },
    /// The address requests listening only, so nothing can be sent.
    #[error("{channel} only listens: leave +listen-only out of the address to send")]
    ListenOnly { channel: Channel },
    /// Waiting for the adapter failed.
    #[error("can't wait for frames of {channel}: {source}")]
    Wait {
        channel: Channel,
        /// The system's error.
        source: std::io::Error,
    },
}

impl PcanError {
    /// The instruction for installing the library.
    const fn library_remedy() -> &'static str {
        if cfg!(target_env = "musl") {
            "this program is static and loads no libraries: use the interface that Linux itself makes of the \
             adapter (ip link, socketcan:can0), or a canvass that cargo has built on this machine"
        } else if cfg!(windows) {
            "install PEAK's drivers with PCAN-Basic"
        } else {
            "install PEAK's driver with PCAN-Basic, or use the interface that Linux itself makes of the adapter (ip link, \
             socketcan:can0)"
        }
    }
}
