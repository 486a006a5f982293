//! PDO: process data, laid out as its mapping says.
//!
//! A PDO's payload has no structure of its own: mapping entries (1600h.., 1A00h..) name the objects whose values
//! follow each other, least significant bit first.

use super::{Field, Layout};
use crate::Multiplexer;
use std::fmt;

/// The default CAN-IDs of node 0 for TPDO 1 to 4; the node-ID is added.
pub const TPDO_BASES: [u16; 4] = [0x180, 0x280, 0x380, 0x480];
/// The default CAN-IDs of node 0 for RPDO 1 to 4; the node-ID is added.
pub const RPDO_BASES: [u16; 4] = [0x200, 0x300, 0x400, 0x500];

/// The layout of a PDO whose mapping is unknown.
pub static PDO: Layout = Layout { name: "PDO", fields: &[Field::new("data", 0, 0, 64)] };

/// One entry of a PDO mapping.
///
/// ```text
/// bits 31..16: index    bits 15..8: sub-index    bits 7..0: length in bits
/// ```
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct MappingEntry(pub u32);

impl MappingEntry {
    /// An entry for an object and its number of bits.
    pub const fn new(object: Multiplexer, bits: u8) -> Self {
        Self((object.index.0 as u32) << 16 | (object.sub.0 as u32) << 8 | bits as u32)
    }

    /// The mapped object.
    pub const fn object(self) -> Multiplexer {
        Multiplexer::new((self.0 >> 16) as u16, (self.0 >> 8) as u8)
    }

    /// Number of bits in the PDO.
    pub const fn bits(self) -> u8 {
        self.0 as u8
    }

    /// Whether the entry is a dummy entry (0001h to 0007h): a gap of the size of this data type.
    pub const fn is_dummy(self) -> bool {
        matches!(self.0 >> 16, 1..=7)
    }
}

/// The time at which a PDO is sent or its values take effect (sub-index 2 of 1400h.., 1800h..).
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TransmissionType(pub u8);

impl TransmissionType {
    /// Synchronous, acyclic.
    pub const SYNCHRONOUS_ACYCLIC: Self = Self(0);
    /// Sampled at SYNC, sent on a remote frame.
    pub const RTR_SYNCHRONOUS: Self = Self(252);
    /// Sent on a remote frame.
    pub const RTR_EVENT_DRIVEN: Self = Self(253);
    /// Event-driven, manufacturer-specific event.
    pub const EVENT_MANUFACTURER: Self = Self(254);
    /// Event-driven, event of the device profile.
    pub const EVENT_PROFILE: Self = Self(255);

    /// The number of SYNCs per PDO, for 1 to 240.
    pub const fn cycle(self) -> Option<u8> {
        match self.0 {
            n @ 1..=240 => Some(n),
            _ => None,
        }
    }

    /// Whether the value is reserved for TPDOs: 241 to 251. For RPDOs 252 and 253 are reserved as well.
    pub const fn is_reserved_for_tpdo(self) -> bool {
        matches!(self.0, 241..=251)
    }
}

/// Takes `bits` bits (at most 64) from bit `offset` of a payload; `None` if the payload is too short.
///
/// ```
/// use canvass_analyzer::wire::pdo::{extract, insert};
///
/// // A position of 20 bits after a status of 4.
/// let payload = [0xA5, 0x5A, 0x01, 0x00];
/// assert_eq!(extract(&payload, 0, 4), Some(0x5));
/// assert_eq!(extract(&payload, 4, 20), Some(0x15AA));
/// assert_eq!(extract(&payload, 16, 32), None, "the payload is too short");
/// let mut other = [0; 4];
/// assert!(insert(&mut other, 0, 4, 0x5) && insert(&mut other, 4, 20, 0x15AA));
/// assert_eq!(other, payload);
/// ```
pub fn extract(payload: &[u8], offset: usize, bits: u8) -> Option<u64> {
    let end = offset.checked_add(usize::from(bits))?;
    if bits > 64 || end > payload.len().checked_mul(8)? {
        return None;
    }
    let (first, shift) = (offset / 8, offset % 8);
    let touched = payload.get(first..end.div_ceil(8))?;
    // The first eight bytes hold bits 0 to 63; values that begin inside a byte may need bits of a ninth byte.
    let (lower, ninth) = touched.split_at(touched.len().min(8));
    let mut bytes = [0; 8];
    bytes[..lower.len()].copy_from_slice(lower);
    let lower = u64::from_le_bytes(bytes) >> shift;
    let value = ninth.first().map_or(lower, |byte| lower | u64::from(*byte) << (64 - shift));
    Some(if bits == 64 { value } else { value & ((1 << bits) - 1) })
}

/// Writes the lower `bits` bits (at most 64) of a value to bit `offset` of a payload; `false` if the payload is too
/// short, which then stays unchanged.
pub fn insert(payload: &mut [u8], offset: usize, bits: u8, value: u64) -> bool {
    let Some(end) = offset.checked_add(usize::from(bits)) else { return false };
    if bits > 64 || end > payload.len() * 8 {
        return false;
    }
    // Nearly all objects consist of whole bytes at byte offsets.
    if offset.is_multiple_of(8) && bits.is_multiple_of(8) {
        let bytes = value.to_le_bytes();
        payload[offset / 8..end / 8].copy_from_slice(&bytes[..usize::from(bits / 8)]);
        return true;
    }
    for (n, bit) in (offset..end).enumerate() {
        let mask = 1 << (bit % 8);
        payload[bit / 8] = payload[bit / 8] & !mask | ((value >> n & 1) as u8) << (bit % 8);
    }
    true
}

/// Writes `6004h:00, 32 bits`.
impl fmt::Display for MappingEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} bits", self.object(), self.bits())
    }
}

impl fmt::Debug for MappingEntry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MappingEntry({self})")
    }
}

impl fmt::Display for TransmissionType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.0, self.moment())
    }
}

/// The moment at which a TPDO is sent. Displays as `at every SYNC`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Moment(TransmissionType);

impl TransmissionType {
    /// The moment at which a TPDO of this type is sent.
    pub const fn moment(self) -> Moment {
        Moment(self)
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0.0 {
            0 => "at the SYNC after an event",
            1 => "at every SYNC",
            n @ 2..=240 => return write!(f, "at every {n}th SYNC"),
            241..=251 => "reserved",
            252 => "sampled at SYNC, sent on RTR",
            253 => "sent on RTR",
            254 => "manufacturer-specific event",
            255 => "event of the device profile",
        })
    }
}

impl fmt::Debug for TransmissionType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "TransmissionType({self})")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn position_as_the_manual_maps_it() {
        let entry = MappingEntry(0x6004_0020);
        assert_eq!((entry.object(), entry.bits()), (Multiplexer::new(0x6004, 0), 32));
        assert_eq!(MappingEntry::new(entry.object(), 32), entry);
        // 1BFh BA 4C 00 00 of the bus trace in Kübler manual 000, 5.7.7.
        assert_eq!(extract(&[0xBA, 0x4C, 0, 0], 0, 32), Some(0x4CBA));
        assert_eq!(extract(&[0xBA, 0x4C, 0, 0], 1, 32), None);
    }

    proptest! {
        #[test]
        fn what_is_put_in_comes_out(offset in 0usize..64, bits in 0u8..=64, value: u64, background: [u8; 8]) {
            let mut payload = background;
            let fits = insert(&mut payload, offset, bits, value);
            prop_assert_eq!(fits, offset + usize::from(bits) <= 64);
            let mask = if bits == 64 { u64::MAX } else { (1 << bits) - 1 };
            prop_assert_eq!(extract(&payload, offset, bits), fits.then_some(value & mask));
            let rest = |bytes: [u8; 8]| if fits { u64::from_le_bytes(bytes) & !(mask << offset.min(63)) } else { 0 };
            prop_assert!(bits == 0 || offset == 64 || rest(payload) == rest(background));
        }
    }
}
