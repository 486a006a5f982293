//! Parses several digits at once in one machine word: every character is a byte of the word, and arithmetic on the
//! word works on all bytes, as long as no byte overflows into the next.

use crate::grammar::nibble;

/// A word with the value `byte` in each byte.
const fn each(byte: u8) -> u64 {
    u64::from_ne_bytes([byte; 8])
}

/// A word of sixteen bytes with the value `byte` in each.
const fn each_of_16(byte: u8) -> u128 {
    u128::from_ne_bytes([byte; 16])
}

/// The number of four decimal digits.
#[inline]
pub(crate) const fn four_decimal(text: [u8; 4]) -> Option<u32> {
    let word = u32::from_le_bytes(text);
    let values = word.wrapping_sub(0x3030_3030);
    if (values | word.wrapping_add(0x4646_4646)) & 0x8080_8080 != 0 {
        return None;
    }
    let pairs = values.wrapping_mul(10).wrapping_add(values >> 8);
    Some((pairs & 0xFF) * 100 + (pairs >> 16 & 0xFF))
}

/// Whether all eight characters are decimal digits.
#[inline]
pub(crate) const fn all_decimal(text: [u8; 8]) -> bool {
    let word = u64::from_le_bytes(text);
    (word.wrapping_sub(each(b'0')) | word.wrapping_add(each(0x7F - b'9'))) & each(0x80) == 0
}

/// The number of eight decimal digits.
#[inline(always)]
pub(crate) const fn eight_decimal(text: [u8; 8]) -> Option<u32> {
    if !all_decimal(text) {
        return None;
    }
    let values = u64::from_le_bytes(text).wrapping_sub(each(b'0'));
    let pairs = values.wrapping_mul(10).wrapping_add(values >> 8) & 0x00FF_00FF_00FF_00FF;
    let fours = pairs.wrapping_mul(100).wrapping_add(pairs >> 16) & 0x0000_FFFF_0000_FFFF;
    Some((fours.wrapping_mul(10_000).wrapping_add(fours >> 32)) as u32)
}

/// The number of three hexadecimal digits.
#[inline]
pub(crate) fn three_hex(text: [u8; 3]) -> Option<u32> {
    let [a, b, c] = text.map(nibble);
    Some(u32::from(a?) << 8 | u32::from(b?) << 4 | u32::from(c?))
}

/// Number of leading hexadecimal digits.
#[inline]
pub(crate) const fn hex_count(text: [u8; 16]) -> usize {
    hex_values(u128::from_le_bytes(text)).0
}

/// Number of leading hexadecimal digits, and the bytes that pairs of them spell; the other bytes are zero.
#[inline]
pub(crate) const fn hex_prefix(text: [u8; 16]) -> (usize, [u8; 8]) {
    let word = u128::from_le_bytes(text);
    let (count, nibbles) = hex_values(word);
    // The first digit of a pair is the upper half of the byte.
    let pairs = (nibbles << 4 | nibbles >> 8) & 0x00FF_00FF_00FF_00FF_00FF_00FF_00FF_00FF;
    let low = packed(pairs as u64);
    let high = packed((pairs >> 64) as u64);
    let bytes = low as u64 | (high as u64) << 32;
    // An odd last digit is not used.
    let kept = if count >= 16 { u64::MAX } else { (1 << (8 * (count / 2))) - 1 };
    (count, (bytes & kept).to_le_bytes())
}

/// The number of leading hexadecimal digits, and the value of each digit.
#[inline]
const fn hex_values(word: u128) -> (usize, u128) {
    const HIGH: u128 = each_of_16(0x80);
    let is_ascii = !word & HIGH;
    let seven = word & !HIGH;
    let digit = at_least(seven, b'0') & !at_least(seven, b'9' + 1);
    let letters = seven | each_of_16(0x20);
    let letter = at_least(letters, b'a') & !at_least(letters, b'f' + 1);
    let is_hex = (digit | letter) & is_ascii;
    let count = (!is_hex & HIGH).trailing_zeros() as usize / 8;
    // Bit 6 is set in letters only: a letter adds 9 to its lower half, which is 1 for A = 41h.
    let nine = (word >> 6 & each_of_16(1)).wrapping_mul(9);
    (count, (word & each_of_16(0x0F)).wrapping_add(nine) & each_of_16(0x0F))
}

/// Sets the upper bit of each byte that is at least `least`: adding the difference to 80h carries into that bit. All
/// bytes are below 80h.
#[inline]
const fn at_least(seven: u128, least: u8) -> u128 {
    seven.wrapping_add(each_of_16(0x80 - least))
}

/// Packs every other byte into 32 bits.
#[inline]
const fn packed(pairs: u64) -> u32 {
    let fours = (pairs | pairs >> 8) & 0x0000_FFFF_0000_FFFF;
    (fours | fours >> 16) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn four_digits_at_once() {
        for n in 0..10_000_u32 {
            let text = format!("{n:04}");
            assert_eq!(four_decimal(text.as_bytes().try_into().unwrap()), Some(n));
        }
    }

    #[test]
    fn any_other_character_at_any_place_is_seen() {
        for other in 0..=u8::MAX {
            for place in 0..8 {
                let mut text = *b"09900990";
                text[place] = other;
                assert_eq!(eight_decimal(text).is_some(), other.is_ascii_digit(), "{text:?}");
                if let Some(four) = text.first_chunk::<4>()
                    && place < 4
                {
                    assert_eq!(four_decimal(*four).is_some(), other.is_ascii_digit(), "{text:?}");
                }
            }
            for place in 0..16 {
                let mut text = *b"09afAF9009afAF90";
                text[place] = other;
                let expected = if other.is_ascii_hexdigit() { 16 } else { place };
                assert_eq!(hex_prefix(text).0, expected, "{text:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn three_digits_are_read_as_the_library_reads_them(text in "[0-9a-fA-F]{2}[0-9a-gA-G/:@`]") {
            prop_assert_eq!(three_hex(text.as_bytes().try_into().unwrap()), u32::from_str_radix(&text, 16).ok());
        }

        #[test]
        fn numbers_are_read_as_the_library_reads_them(text in "[0-9]{8}") {
            prop_assert_eq!(eight_decimal(text.as_bytes().try_into().unwrap()), text.parse().ok());
        }

        #[test]
        fn bytes_are_read_as_the_library_reads_them(digits in "[0-9a-fA-F]{0,16}", rest in any::<[u8; 16]>()) {
            let mut text = rest;
            text[..digits.len()].copy_from_slice(digits.as_bytes());
            if let Some(next) = text.get_mut(digits.len()) {
                *next = b'#';
            }
            let (count, bytes) = hex_prefix(text);
            prop_assert_eq!(count, digits.len());
            for (n, byte) in bytes.iter().enumerate() {
                let two = digits.get(2 * n..2 * n + 2).map_or(0, |two| u8::from_str_radix(two, 16).unwrap());
                prop_assert_eq!(*byte, two);
            }
        }
    }
}
