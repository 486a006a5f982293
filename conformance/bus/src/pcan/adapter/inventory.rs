//! The adapters of PEAK on this machine.

use super::library::{Library, Parameter};
use crate::pcan::{Channel, PcanError};
use std::fmt;

/// PEAK's library on this machine, and the channels that it finds.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Installed {
    /// The version of the library, if the library gives it.
    pub version: Option<String>,
    /// The available channels.
    pub channels: Vec<Present>,
}

/// An available channel.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Present {
    /// The channel.
    pub channel: Channel,
    /// Whether the channel can be used.
    pub condition: Condition,
    /// The name of the adapter, such as `PCAN-USB`, if the library gives it.
    pub adapter: Option<String>,
}

/// Whether a channel can be used.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    /// The channel is free.
    Available,
    /// Another program uses it.
    Occupied,
    /// PEAK's own viewer uses the channel, which can be shared at the viewer's bit rate.
    Shared,
}

impl Condition {
    const fn of(told: u32) -> Option<Self> {
        match told {
            1 => Some(Self::Available),
            2 => Some(Self::Occupied),
            3 => Some(Self::Shared),
            _ => None,
        }
    }
}

/// Lists the channels without opening any.
///
/// # Errors
/// [`PcanError`] if the library is missing.
pub fn installed() -> Result<Installed, PcanError> {
    let library = Library::installed()?;
    let present = |channel| {
        let condition = Condition::of(library.number(channel, Parameter::CONDITION).ok()?)?;
        Some(Present { channel, condition, adapter: library.text(channel, Parameter::HARDWARE_NAME) })
    };
    let version = library.text(Channel::NONE, Parameter::API_VERSION);
    Ok(Installed { version, channels: Channel::all().filter_map(present).collect() })
}

/// The channel and its adapter: `PCAN_USBBUS1 (PCAN-USB)`.
impl fmt::Display for Present {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.channel)?;
        if let Some(adapter) = &self.adapter {
            write!(f, " ({adapter})")?;
        }
        match self.condition {
            Condition::Available => Ok(()),
            Condition::Occupied => f.write_str(", in use by another program"),
            Condition::Shared => f.write_str(", in use by PCAN-View: at its bit rate"),
        }
    }
}
