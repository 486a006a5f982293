//! Settings: entries that a configuration holds, and entries that it leaves out.

use crate::dictionary::data_type::DataType;
use crate::dictionary::manual::KnownDevice;
use crate::dictionary::object::Entry;
use crate::identity::{CobId, Multiplexer, NodeId};
use crate::object::{self, Acting};
use crate::wire::pdo::MappingEntry;
use std::collections::BTreeSet;
use std::fmt;

/// Why an entry is no part of a configuration that is read from a device.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Excluded {
    /// The entry is read-only or write-only.
    Access,
    /// The entry acts when it is written.
    Acts(Acting),
    /// An RPDO carries the entry: it is an output, not a setting.
    Process,
    /// The node-ID or bit rate, which a DCF has in its commissioning.
    Commissioning,
    /// The description forbids to read it when everything is read (ObjFlags, bit 1).
    Unreadable,
    /// A DOMAIN: a file, which a DCF holds in a file of its own.
    Domain,
}

/// What writing a setting changes beyond the device itself, so that the user must allow it.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Hazard {
    /// The device gets another node-ID at its next start.
    NodeId,
    /// The device gets another bit rate at its next start.
    BitRate,
    /// The device becomes NMT master, or starts by itself (1F80h).
    Startup,
    /// The device produces SYNC: two producers disturb a network.
    SyncProducer,
    /// The entry acts when it is written.
    Acts(Acting),
    /// An RPDO carries the entry: it is an output.
    Process,
}

/// The highest number of objects in a PDO (CiA 301, 7.5.2.36).
const MOST_MAPPED: u64 = 64;

/// A device, as far as it decides which of its entries are settings.
pub struct DeviceSettings<'a> {
    known: &'a KnownDevice,
    /// The entries that an RPDO carries.
    in_rpdos: BTreeSet<Multiplexer>,
}

impl<'a> DeviceSettings<'a> {
    /// A device whose RPDO mappings (1600h to 17FFh) have these values.
    pub fn new(known: &'a KnownDevice, mapping: impl Fn(Multiplexer) -> Option<u64>) -> Self {
        let mapped = (0x1600..=0x17FF).flat_map(|index| {
            let count = mapping(Multiplexer::new(index, 0)).filter(|count| *count <= MOST_MAPPED).unwrap_or(0);
            (1..=count as u8).map(move |sub| Multiplexer::new(index, sub))
        });
        let mapped = mapped.filter_map(|at| u32::try_from(mapping(at)?).ok());
        Self { known, in_rpdos: mapped.map(|entry| MappingEntry(entry).object()).collect() }
    }

    /// A device that has the values of its description: the configured ones, else the defaults.
    pub fn described(known: &'a KnownDevice, node: NodeId) -> Self {
        let value = |at: Multiplexer| known.description.dictionary.entry(at).ok()?.start_value(node)?.to_raw();
        Self::new(known, value)
    }

    /// Why an entry is left out when a configuration is read; `None` for a setting.
    pub fn excluded(&self, at: Multiplexer, entry: &Entry) -> Option<Excluded> {
        let settings = &self.known.manual.settings;
        if !entry.access.is_writable() || !entry.access.is_readable() {
            return Some(Excluded::Access);
        }
        if let Some(acting) = self.known.manual.acting(at, Some(&self.known.description)) {
            return Some(Excluded::Acts(acting));
        }
        if self.in_rpdos.contains(&at) {
            return Some(Excluded::Process);
        }
        if [settings.node_id, settings.bit_rate].contains(&Some(at)) {
            return Some(Excluded::Commissioning);
        }
        if entry.flags.refuses_read_on_scan() {
            return Some(Excluded::Unreadable);
        }
        (entry.data_type == DataType::DOMAIN).then_some(Excluded::Domain)
    }

    /// What writing a value to an entry changes beyond the device; `None` for a harmless setting.
    pub fn hazard(&self, at: Multiplexer, value: &[u8]) -> Option<Hazard> {
        let settings = &self.known.manual.settings;
        if settings.node_id == Some(at) || at.index.0 == object::NODE_ID {
            return Some(Hazard::NodeId);
        }
        if settings.bit_rate == Some(at) {
            return Some(Hazard::BitRate);
        }
        if let Some(acting) = self.known.manual.acting(at, Some(&self.known.description)) {
            return Some(Hazard::Acts(acting));
        }
        if self.in_rpdos.contains(&at) {
            return Some(Hazard::Process);
        }
        let produces = || value.first_chunk().is_some_and(|bytes| u32::from_le_bytes(*bytes) & CobId::NO_RTR != 0);
        match at.index.0 {
            object::NMT_STARTUP => Some(Hazard::Startup),
            object::COB_ID_SYNC if produces() => Some(Hazard::SyncProducer),
            _ => None,
        }
    }

    /// Whether writing the entry acts at once, so that it is no setting.
    pub fn acts(&self, at: Multiplexer) -> bool {
        matches!(self.hazard(at, &[]), Some(Hazard::Acts(_) | Hazard::Process))
    }
}

impl fmt::Display for Excluded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Access => f.write_str("read-only or write-only"),
            Self::Acts(acting) => f.write_str(told(*acting)),
            Self::Process => f.write_str("an output that an RPDO carries"),
            Self::Commissioning => f.write_str("node-ID or bit rate"),
            Self::Unreadable => f.write_str("not to be read with everything else"),
            Self::Domain => f.write_str("a DOMAIN"),
        }
    }
}

impl fmt::Display for Hazard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NodeId => "changes the node-ID",
            Self::BitRate => "changes the bit rate",
            Self::Startup => "makes the device NMT master, or lets it start by itself",
            Self::SyncProducer => "makes the device produce SYNC",
            Self::Acts(acting) => told(*acting),
            Self::Process => "sets an output that an RPDO carries",
        })
    }
}

const fn told(acting: Acting) -> &'static str {
    match acting {
        Acting::Clears => "clears a history or a counter",
        Acting::Stores => "stores or restores parameters",
        Acting::SetsClock => "sets a running clock",
        Acting::Commands => "carries out a command",
        Acting::MovesZeroPoint => "moves the zero point",
    }
}
