//! Why an adapter of PEAK does not work, and what to do about it.

use super::channel::Channel;
use super::status::Status;
use canvass_traces::Duration;

/// Each says what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PcanError {
    /// PEAK's library is not there.
    #[error("can't load {name}, PEAK's library ({reason}): {}", Self::library_remedy())]
    NoLibrary {
        /// Its file.
        name: String,
        /// What the system reports.
        reason: String,
    },
    /// The library lacks a function.
    #[error("{name} has no {function} ({reason}): install the current version of PCAN-Basic")]
    OldLibrary {
        /// Its file.
        name: String,
        /// What it lacks.
        function: &'static str,
        /// What the system reports.
        reason: String,
    },
    /// There are no registers for that bit rate.
    #[error(
        "PCAN-Basic has no bit rate of {0} bit/s: expected one of 5k, 10k, 20k, 33333, 47619, 50k, 83333, 95238, 100k, \
         125k, 250k, 500k, 800k, 1M"
    )]
    BitRate(u32),
    /// A function of the library fails.
    #[error("can't {action} {channel}: {status}")]
    Failed {
        channel: Channel,
        /// What was tried.
        action: &'static str,
        /// What the library gives back.
        status: Status,
    },
    /// Nothing leaves the transmit queue.
    #[error("{channel} has sent nothing for {waited}: nobody acknowledges, or the bus is full ({status})")]
    QueueFull {
        channel: Channel,
        /// How long.
        waited: Duration,
        /// Of the bus.
        status: Status,
    },
    /// The address asks for silence.
    #[error("{channel} only listens: leave +listen-only out of the address to send")]
    ListenOnly { channel: Channel },
    /// The way to the adapter can't be watched.
    #[error("can't wait for frames of {channel}: {source}")]
    Wait {
        channel: Channel,
        /// What the system reports.
        source: std::io::Error,
    },
}

impl PcanError {
    /// How to get the library.
    const fn library_remedy() -> &'static str {
        if cfg!(target_env = "musl") {
            "this program is static and loads no libraries: use the interface that Linux itself makes of the adapter \
             (ip link, socketcan:can0), or a canvass that cargo has built on this machine"
        } else if cfg!(windows) {
            "install PEAK's drivers with PCAN-Basic"
        } else {
            "install PEAK's driver with PCAN-Basic, or use the interface that Linux itself makes of the adapter (ip link, \
             socketcan:can0)"
        }
    }
}
