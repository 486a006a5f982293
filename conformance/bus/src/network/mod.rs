//! Buses that are reached over a network: socketcand, cannelloni, and python-can's multicast.

mod address;
#[cfg(not(target_family = "wasm"))]
mod bus;
#[cfg(not(target_family = "wasm"))]
mod cannelloni;
#[cfg(not(target_family = "wasm"))]
mod multicast;
#[cfg(not(target_family = "wasm"))]
mod reader;
#[cfg(not(target_family = "wasm"))]
mod socketcand;

pub use address::{Carrier, NetworkAddress};
#[cfg(not(target_family = "wasm"))]
pub use bus::NetworkBus;

use std::io;

/// Why a bus over a network does not work, with a remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// The connection can't be opened.
    #[error("can't open {name}: {source}{}", remedy(source))]
    Open {
        /// The address.
        name: String,
        /// The system's error.
        source: io::Error,
    },
    /// The other end refuses.
    #[error("{name}: the other end answered \"{answer}\"")]
    Refused {
        /// The address.
        name: String,
        /// Its answer.
        answer: String,
    },
    /// The connection is lost at the moment.
    #[error("{name} is not connected; canvass connects again by itself")]
    NotConnected {
        /// The address.
        name: String,
    },
}

fn remedy(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::ConnectionRefused => ": no program listens there",
        io::ErrorKind::AddrInUse => ": another program has this port",
        _ => "",
    }
}
