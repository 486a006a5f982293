//! The names of the bits of registers, by the standards.

use super::profile::logical_device;
use crate::identity::Index;

/// Bits 0 to 7 of 1001h, and of the error register in an EMCY.
const ERROR_REGISTER: &[&str] = &[
    "generic error",
    "current",
    "voltage",
    "temperature",
    "communication error",
    "device profile specific",
    "reserved",
    "manufacturer specific",
];

/// The names of an object's bits, from bit 0 on, as the standard defines them; empty for most objects. A bit without a
/// name has an empty one.
pub(crate) fn bit_names(index: Index, profile: Option<u16>) -> &'static [&'static str] {
    match (index.0, profile) {
        (0x1001, _) => ERROR_REGISTER,
        (0x6000..=0x9FFF, Some(number)) => {
            logical_device(index, number).map_or(&[], |device| device.profile.bits(device.object))
        }
        _ => &[],
    }
}

/// The object whose bits have the same meaning, such as the alarms for the supported alarms; `None` for most objects.
pub(crate) fn same_bits(index: Index, profile: Option<u16>) -> Option<Index> {
    let device = logical_device(index, profile?)?;
    let twin = device.profile.same_bits(device.object)?;
    // The objects of a further logical device follow at the same distance.
    Some(Index(index.0 - device.object.0 + twin.0))
}

/// The name of an object's bit, if the standard defines it; manufacturer-specific bits have none.
pub fn bit_name(index: Index, bit: u8, profile: Option<u16>) -> Option<&'static str> {
    bit_names(index, profile).get(usize::from(bit)).copied().filter(|name| !name.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_have_names() {
        assert_eq!(bit_name(Index(0x1001), 4, None), Some("communication error"));
        assert_eq!((bit_name(Index(0x1001), 8, None), bit_name(Index(0x6000), 2, None)), (None, None));
    }
}
