//! The layout of a PDO: its signals.

use super::node::Node;
use super::scaling;
use crate::dictionary::{DataType, Unit};
use crate::wire::pdo::{MappingEntry, extract};
use crate::{Multiplexer, NodeId};

/// The signals of a PDO, in the order of its mapping.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The signals.
    pub signals: Vec<Signal>,
}

/// One mapped object in a PDO.
#[derive(Clone, Debug)]
pub struct Signal {
    /// The object; for a dummy entry the data type's index.
    pub object: Multiplexer,
    /// The first bit in the payload.
    pub offset: usize,
    /// The number of bits.
    pub bits: u8,
    /// The data type, if known.
    pub data_type: Option<DataType>,
    /// The unit of the signal's values, if the device's configuration determines a unit and is known.
    pub scale: Option<Unit>,
    /// The place of the signal, counted from 0, if the PDO maps the same object several times; else `None`.
    pub repetition: Option<u8>,
}

impl Layout {
    /// The layout for a mapping of a node, whose description gives the data types.
    pub fn new(entries: &[MappingEntry], id: NodeId, node: &Node) -> Self {
        let mut offset = 0;
        let signals = entries.iter().enumerate().map(|(n, entry)| {
            let object = entry.object();
            let same = |entries: &[MappingEntry]| entries.iter().filter(|other| other.object() == object).count();
            // A mapping has at most 64 entries.
            let repetition = (same(entries) > 1).then(|| same(&entries[..n]) as u8);
            let data_type = node.data_type(id, object);
            let scale = scaling::scale(node, id, object);
            let signal = Signal { object, offset, bits: entry.bits(), data_type, scale, repetition };
            offset += usize::from(entry.bits());
            signal
        });
        Self { signals: signals.collect() }
    }

    /// The number of bytes that the mapping fills.
    pub fn length(&self) -> usize {
        self.signals.iter().map(|signal| usize::from(signal.bits)).sum::<usize>().div_ceil(8)
    }
}

impl Signal {
    /// Whether the signal is a gap: the object is a data type (CiA 301, dummy mapping).
    pub const fn is_dummy(&self) -> bool {
        matches!(self.object.index.0, 1..=7)
    }

    /// The signal's bits in a payload; `None` if the payload is too short or the signal longer than 64 bits.
    pub fn raw(&self, payload: &[u8]) -> Option<u64> {
        extract(payload, self.offset, self.bits)
    }
}
