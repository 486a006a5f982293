//! PDOs as text: their signals if the mapping is known, else their bytes.

use super::Meaning;
use super::object::Object;
use super::signal::SignalValue;
use super::value::ValueText;
use crate::NodeId;
use crate::message::PdoNumber;
use crate::network::{Layout, Signal};
use crate::wire::mpdo::{Addressing, Mpdo};
use crate::wire::srdo::{Half, Srdo};
use std::fmt;

impl Meaning<'_> {
    pub(super) fn pdo(&self, number: PdoNumber, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{number}")?;
        let payload = self.record.frame.data();
        let node = self.decoded.node.and_then(|node| self.bus.node(node));
        match node.and_then(|node| node.known_layout(number)) {
            Some(layout) => {
                self.layout_signals(layout, payload, f)?;
                if self.is_padded(number) { Ok(()) } else { other_length(layout, payload, f) }
            }
            None => bytes(payload, f),
        }
    }

    /// Whether the device fills up the PDO to the length of the frame, as its manual says.
    fn is_padded(&self, number: PdoNumber) -> bool {
        let PdoNumber::Transmit(tpdo) = number else { return false };
        let node = self.decoded.node.and_then(|node| self.bus.node(node));
        let device = node.and_then(|node| node.device.as_deref());
        self.record.frame.data().len() == 8 && device.is_some_and(|device| device.manual.settings.pads(tpdo))
    }

    pub(super) fn srdo(&self, srdo: &Srdo, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{srdo}")?;
        match self.srdo_layout(srdo) {
            Some(layout) => {
                self.layout_signals(layout, self.record.frame.data(), f)?;
                other_length(layout, self.record.frame.data(), f)
            }
            None => Ok(()),
        }
    }

    /// The layout of an SRDO's data; `None` for the inverted data, which only repeats the data.
    pub(super) fn srdo_layout(&self, srdo: &Srdo) -> Option<&Layout> {
        let node = self.bus.node(self.decoded.node?)?;
        srdo.number.filter(|_| srdo.half == Half::Normal).and_then(|number| node.known_srdo_layout(number))
    }

    pub(super) fn mpdo(&self, number: PdoNumber, mpdo: &Mpdo, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let object = self.mpdo_object(mpdo);
        write!(f, "{number}, multiplexed, {mpdo}: {object} = {}", object.leading(&mpdo.data))
    }

    /// The object of an MPDO, which belongs to the node that the address names.
    pub(super) fn mpdo_object(&self, mpdo: &Mpdo) -> Object<'_> {
        let addressed = match mpdo.addressing {
            Addressing::Source => NodeId::new(mpdo.node).or(self.decoded.node),
            Addressing::Destination => NodeId::new(mpdo.node),
        };
        Object::new(addressed, addressed.and_then(|id| self.bus.node(id)), mpdo.object)
    }

    pub(super) fn multiplexed(&self, mpdo: &Mpdo) -> SignalValue<'_> {
        SignalValue::multiplexed(self.mpdo_object(mpdo), mpdo.data)
    }

    fn layout_signals(&self, layout: &Layout, payload: &[u8], f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (n, signal) in layout.signals.iter().enumerate() {
            f.write_str(if n == 0 { ": " } else { ", " })?;
            self.signal(signal, payload, f)?;
        }
        Ok(())
    }

    fn signal(&self, signal: &Signal, payload: &[u8], f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let node = self.decoded.node.and_then(|node| self.bus.node(node));
        let object = Object::mapped(self.decoded.node, node, signal);
        match signal.raw(payload) {
            Some(raw) => {
                let bytes = raw.to_le_bytes();
                let mapped = &bytes[..usize::from(signal.bits).div_ceil(8).min(8)];
                let value = object.leading(mapped);
                let is_shortened = object.is_shortened_to(signal.bits);
                let value = ValueText { scale: signal.scale.as_ref(), is_shortened, ..value };
                write!(f, "{object} = {value}")
            }
            None => write!(f, "{object} cut off"),
        }
    }
}

/// Writes the length of a payload that is not that of its mapping.
fn other_length(layout: &Layout, payload: &[u8], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match (payload.len(), layout.length()) {
        (length, mapped) if length == mapped => Ok(()),
        (length, mapped) => write!(f, " [length {length}, the mapping fills {mapped}]"),
    }
}

fn bytes(payload: &[u8], f: &mut fmt::Formatter<'_>) -> fmt::Result {
    match payload.len() {
        0 => f.write_str(", no data"),
        1 => f.write_str(", 1 byte, mapping not known"),
        n => write!(f, ", {n} bytes, mapping not known"),
    }
}
