//! `--allow` of `canvass dcf write`: what a configuration may change beyond settings.

use canvass_analyzer::dictionary::configuration::Hazard;
use canvass_analyzer::object::Acting;

/// What the user allows.
#[derive(Clone, Copy, PartialEq, Eq, Debug, clap::ValueEnum)]
pub enum Allowed {
    /// Writes the object with the node-ID for the next start
    NodeId,
    /// Writes the object with the bit rate for the next start
    BitRate,
    /// Writes 1F80h: the device becomes NMT master, or starts by itself
    Startup,
    /// Lets the device produce SYNC
    Sync,
    /// Moves a zero point
    Preset,
    /// Writes outputs and other objects that act: commands, clocks, histories
    Commands,
    /// Writes to a device whose identity (1018h) is not that of the file
    Identity,
    /// Writes to a device that is operational
    Operational,
}

/// What must be allowed for this hazard; `None` if it never is: 1010h and 1011h are for `--store` and `canvass sdo`.
pub const fn needed(hazard: Hazard) -> Option<Allowed> {
    Some(match hazard {
        Hazard::NodeId => Allowed::NodeId,
        Hazard::BitRate => Allowed::BitRate,
        Hazard::Startup => Allowed::Startup,
        Hazard::SyncProducer => Allowed::Sync,
        Hazard::Acts(Acting::MovesZeroPoint) => Allowed::Preset,
        Hazard::Acts(Acting::Stores) => return None,
        Hazard::Acts(Acting::Clears | Acting::SetsClock | Acting::Commands) | Hazard::Process => Allowed::Commands,
    })
}

/// The word of `--allow`.
pub fn word(allowed: Allowed) -> String {
    clap::ValueEnum::to_possible_value(&allowed).map(|value| value.get_name().to_owned()).unwrap_or_default()
}
