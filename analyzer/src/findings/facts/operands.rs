//! The values of objects of a device profile, in PDOs and SDO transfers.

use crate::dictionary::names::is_profile;
use crate::message::{Message, PdoNumber};
use crate::network::sdo::{Direction, Outcome};
use crate::network::{Bus, Decoded, Signal};
use crate::{Multiplexer, NodeId};
use canvass_traces::Record;

/// A value of an object, as a frame shows it.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Operand {
    /// The node with the object.
    pub node: NodeId,
    /// The object.
    pub object: Multiplexer,
    /// The bits of the value.
    pub raw: u64,
    /// Number of bits.
    pub bits: u8,
    /// Whether a client wrote the value; else the device sent it.
    pub written: bool,
}

impl Operand {
    /// The value as a signed number.
    pub const fn signed(self) -> i64 {
        let unused = 64 - if self.bits > 64 { 64 } else { self.bits } as u32;
        if unused == 64 { 0 } else { ((self.raw << unused) as i64) >> unused }
    }
}

/// Collects the values of the objects in a frame, and returns the profile of the frame's node if the profile is
/// registered.
pub fn collect(record: &Record, decoded: &Decoded, bus: &Bus, operands: &mut Vec<Operand>) -> Option<u16> {
    operands.clear();
    let node = decoded.node?;
    match decoded.message {
        Message::Pdo(number) => {
            let known = bus.node(node)?;
            let profile = known.profile(node).filter(|&profile| is_profile(profile))?;
            let payload = record.frame.data();
            let written = matches!(number, PdoNumber::Receive(_));
            let operand = |signal: &Signal| {
                let raw = signal.raw(payload)?;
                Some(Operand { node, object: signal.object, raw, bits: signal.bits, written })
            };
            operands.extend(known.known_layout(number)?.signals.iter().filter_map(operand));
            Some(profile)
        }
        _ if decoded.ends_transfer() => {
            let profile = bus.node(node)?.profile(node).filter(|&profile| is_profile(profile))?;
            operands.extend(transferred(node, decoded, bus));
            Some(profile)
        }
        _ => None,
    }
}

fn transferred(node: NodeId, decoded: &Decoded, bus: &Bus) -> Option<Operand> {
    let transfer = bus.transfer(decoded.channel?)?;
    let (object, data) = (transfer.multiplexer, transfer.data());
    if transfer.outcome != Outcome::Complete || !matches!(object.index.0, 0x2000..=0x9FFF) || data.len() > 8 {
        return None;
    }
    let mut bytes = [0; 8];
    bytes.get_mut(..data.len())?.copy_from_slice(data);
    let written = transfer.direction == Direction::Download;
    Some(Operand { node, object, raw: u64::from_le_bytes(bytes), bits: 8 * data.len() as u8, written })
}
