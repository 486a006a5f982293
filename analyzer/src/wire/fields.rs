//! The fields of messages: which bits of a payload have which meaning.
//!
//! Each type of messages lists its fields beside its parser. Code that goes through all fields of all messages, such as
//! the wire matrix of the selftest, reads these lists, so that it covers a new field without a change.

use super::Wire;
use super::pdo::{extract, insert};

/// A field of a payload. Bit 0 is the lowest bit of byte 0; numbers of several bytes are little-endian.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Field {
    /// The standard's name of the field.
    pub name: &'static str,
    /// The lowest bit.
    pub first: u8,
    /// Number of bits.
    pub bits: u8,
}

/// One sort of message, and its fields.
#[derive(PartialEq, Eq, Debug)]
pub struct Layout {
    /// The standard's name of the message: `initiate download`.
    pub name: &'static str,
    /// The fields, without overlap. The message has no other bits.
    pub fields: &'static [Field],
}

/// A type of messages whose fields are known.
pub trait Fields: Wire {
    /// The layouts of all messages of the type.
    const LAYOUTS: &'static [&'static Layout];

    /// The layout of this message.
    fn layout(&self) -> &'static Layout;
}

impl Field {
    /// The name of a field that is transmitted as 0 and has no meaning yet.
    pub const RESERVED: &'static str = "reserved";

    /// A field that begins at this bit of this byte.
    pub const fn new(name: &'static str, byte: u8, bit: u8, bits: u8) -> Self {
        Self { name, first: byte * 8 + bit, bits }
    }

    /// A reserved field that begins at this bit of this byte.
    pub const fn reserved(byte: u8, bit: u8, bits: u8) -> Self {
        Self::new(Self::RESERVED, byte, bit, bits)
    }

    /// Whether the standard gives the field no meaning.
    pub fn is_reserved(&self) -> bool {
        self.name == Self::RESERVED
    }

    /// The part of the field that a payload of `bytes` bytes has; `None` if the field begins after the end of the
    /// payload.
    #[must_use]
    pub fn within(self, bytes: usize) -> Option<Self> {
        let room = (bytes * 8).checked_sub(usize::from(self.first)).filter(|room| *room > 0)?;
        let bits = u8::try_from(room).unwrap_or(u8::MAX).min(self.bits);
        Some(Self { bits, ..self })
    }

    /// The value of the field in a payload; `None` if the payload ends before the field.
    pub fn get(self, payload: &[u8]) -> Option<u64> {
        extract(payload, usize::from(self.first), self.bits)
    }

    /// Writes a value into the field of a payload. If the payload is too short, changes nothing and returns `false`.
    pub fn set(self, payload: &mut [u8], value: u64) -> bool {
        insert(payload, usize::from(self.first), self.bits, value)
    }
}

impl Layout {
    /// Whether the messages of the layout name an object.
    pub fn has_object(&self) -> bool {
        self.fields.iter().any(|field| field.name == "index")
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The fields of each layout cover every bit of its message once.
    fn cover<M: Fields>(bytes: u8) {
        for layout in M::LAYOUTS {
            let mut bits: Vec<u8> =
                layout.fields.iter().flat_map(|field| field.first..field.first + field.bits).collect();
            bits.sort_unstable();
            assert_eq!(bits, (0..bytes * 8).collect::<Vec<u8>>(), "{}", layout.name);
        }
    }

    /// Every bit of a field that is not reserved changes the parsed message, and no reserved bit does. `passed_over`
    /// names fields that carry a value only in some messages of a layout.
    pub(crate) fn heeded<M: Fields + PartialEq + std::fmt::Debug>(
        payload: &[u8],
        passed_over: impl Fn(&M, Field) -> bool,
    ) {
        let Ok(message) = M::read(payload) else { return };
        for field in message.layout().fields.iter().filter(|field| !passed_over(&message, **field)) {
            for bit in field.first..field.first + field.bits {
                let mut changed = payload.to_vec();
                let Some(byte) = changed.get_mut(usize::from(bit / 8)) else { continue };
                *byte ^= 1 << (bit % 8);
                let is_heeded = M::read(&changed).ok() != Some(M::read(payload).unwrap());
                assert_eq!(is_heeded, !field.is_reserved(), "{message:?}, {}, bit {bit}", field.name);
            }
        }
    }

    #[test]
    fn the_fields_cover_every_message() {
        use crate::wire::{emcy, error_control, lmt, lss, nmt, sdo, sync, time};
        cover::<nmt::Nmt>(2);
        cover::<sdo::Request>(8);
        cover::<lss::Request>(8);
        cover::<lmt::Request>(8);
        cover::<sdo::Response>(8);
        cover::<sdo::BlockSegment>(8);
        cover::<error_control::ErrorControl>(1);
        cover::<emcy::Emcy>(8);
        cover::<sync::Sync>(1);
        cover::<time::TimeOfDay>(6);
        cover::<lss::Response>(8);
        cover::<lmt::Response>(8);
    }

    #[test]
    fn a_field_ends_with_its_payload() {
        let field = Field::new("value", 1, 0, 32);
        assert_eq!(field.within(3).map(|field| field.bits), Some(16));
        assert_eq!((field.within(1), field.within(8)), (None, Some(field)));
        let mut payload = [0xA5; 3];
        assert!(!field.set(&mut payload, 0) && field.get(&payload).is_none(), "the payload is too short");
        assert!(field.within(3).is_some_and(|field| field.set(&mut payload, 0x1234)));
        assert_eq!(payload, [0xA5, 0x34, 0x12]);
    }
}
