//! Numbers and strings appended to a buffer, without allocating.

use crate::escape::acts;
use canvass_analyzer::Meaning;
use std::fmt::{self, Display, Write as _};

pub const HEX: &[u8; 16] = b"0123456789ABCDEF";

/// The two hexadecimal digits of every byte: one look-up for both digits, without shifts.
static HEX_PAIRS: [[u8; 2]; 256] = {
    let mut pairs = [[0; 2]; 256];
    let mut byte = 0;
    while byte < 256 {
        pairs[byte] = [HEX[byte >> 4], HEX[byte & 15]];
        byte += 1;
    }
    pairs
};

/// The two decimal digits of 0 to 99.
static DECIMAL_PAIRS: [[u8; 2]; 100] = {
    let mut pairs = [[0; 2]; 100];
    let mut n = 0;
    while n < 100 {
        pairs[n] = [b'0' + (n / 10) as u8, b'0' + (n % 10) as u8];
        n += 1;
    }
    pairs
};

/// The two hexadecimal digits of a byte.
pub(crate) fn hex_pair(byte: u8) -> [u8; 2] {
    HEX_PAIRS[usize::from(byte)]
}

/// Appends the first `len` bytes of a block. Copying the whole block and cutting the rest costs less than a copy of
/// unknown length.
#[inline]
pub fn push_front<const N: usize>(out: &mut Vec<u8>, block: &[u8; N], len: usize) {
    let end = out.len() + len.min(N);
    out.extend_from_slice(block);
    out.truncate(end);
}

/// Appends two hexadecimal digits for each byte, with `separator` between the bytes.
pub(crate) fn push_hex(out: &mut Vec<u8>, bytes: &[u8], separator: Option<u8>) {
    // Eight bytes are appended at a time, as growing the buffer costs more than the digits.
    for (n, eight) in bytes.chunks(8).enumerate() {
        match separator {
            Some(separator) => {
                if n > 0 {
                    out.push(separator);
                }
                let mut digits = [separator; 24];
                for (place, &byte) in digits.chunks_exact_mut(3).zip(eight) {
                    place[..2].copy_from_slice(&hex_pair(byte));
                }
                push_front(out, &digits, 3 * eight.len() - 1);
            }
            None => {
                let mut digits = [0; 16];
                for (place, &byte) in digits.chunks_exact_mut(2).zip(eight) {
                    place.copy_from_slice(&hex_pair(byte));
                }
                push_front(out, &digits, 2 * eight.len());
            }
        }
    }
}

/// Appends the lower `digits` (at most 8) hexadecimal digits of a number.
pub(crate) fn push_hex_number(out: &mut Vec<u8>, number: u32, digits: usize) {
    let [a, b, c, d] = number.to_be_bytes().map(hex_pair);
    let shown = [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]];
    out.extend_from_slice(&shown[shown.len() - digits.min(shown.len())..]);
}

/// Appends a decimal number.
pub(crate) fn push_decimal(out: &mut Vec<u8>, mut n: u64) {
    if n < 10 {
        return out.push(b'0' + n as u8);
    }
    let mut digits = [0; 20];
    let mut at = digits.len();
    while n >= 10 {
        at -= 2;
        digits[at..at + 2].copy_from_slice(&DECIMAL_PAIRS[(n % 100) as usize]);
        n /= 100;
    }
    if n > 0 {
        at -= 1;
        digits[at] = b'0' + n as u8;
    }
    out.extend_from_slice(&digits[at..]);
}

/// Appends the last `width` (at most 20) decimal digits of a number.
pub fn push_fraction(out: &mut Vec<u8>, mut n: u64, width: usize) {
    let mut digits = [b'0'; 20];
    for pair in digits.rchunks_exact_mut(2).take(width.div_ceil(2)) {
        pair.copy_from_slice(&DECIMAL_PAIRS[(n % 100) as usize]);
        n /= 100;
    }
    out.extend_from_slice(&digits[digits.len() - width.min(digits.len())..]);
}

/// Appends the last six decimal digits of a number, the usual precision of times.
#[inline]
pub(crate) fn push_six_digits(out: &mut Vec<u8>, n: u32) {
    let [a, b, c] = [n / 10_000, n / 100, n].map(|pair| DECIMAL_PAIRS[(pair % 100) as usize]);
    out.extend_from_slice(&[a[0], a[1], b[0], b[1], c[0], c[1]]);
}

/// Appends blanks up to `width` columns from `start`.
pub fn pad(out: &mut Vec<u8>, start: usize, width: usize) {
    let mut missing = (start + width).saturating_sub(out.len());
    while missing > 0 {
        push_front(out, b"                                ", missing);
        missing = missing.saturating_sub(32);
    }
}

/// Appends a text.
pub(crate) fn push_text(out: &mut Vec<u8>, text: impl Display) {
    // Writing to a vector can't fail.
    let _ = write!(Bytes(out), "{text}");
}

/// A byte buffer as a writer of text.
struct Bytes<'a>(&'a mut Vec<u8>);

impl fmt::Write for Bytes<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.extend_from_slice(text.as_bytes());
        Ok(())
    }
}

/// Appends the meaning of a frame.
pub(crate) fn push_meaning(out: &mut Vec<u8>, meaning: &Meaning<'_>) {
    match meaning.fixed() {
        Some(text) => out.extend_from_slice(text.as_bytes()),
        None => push_text(out, meaning),
    }
}

/// Appends a JSON string. Characters that act instead of being shown are escaped, like those that JSON forbids.
pub(crate) fn push_json_string(out: &mut Vec<u8>, text: impl Display) {
    out.push(b'"');
    let _ = write!(JsonEscaped(out), "{text}");
    out.push(b'"');
}

struct JsonEscaped<'a>(&'a mut Vec<u8>);

impl fmt::Write for JsonEscaped<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        if text.bytes().all(|byte| matches!(byte, b' '..=b'~') && byte != b'"' && byte != b'\\') {
            self.0.extend_from_slice(text.as_bytes());
            return Ok(());
        }
        text.chars().for_each(|c| self.push(c));
        Ok(())
    }
}

impl JsonEscaped<'_> {
    fn push(&mut self, c: char) {
        match c {
            '"' | '\\' => self.0.extend_from_slice(&[b'\\', c as u8]),
            c if acts(c) => {
                for unit in c.encode_utf16(&mut [0; 2]) {
                    self.0.extend_from_slice(b"\\u");
                    push_hex_number(self.0, u32::from(*unit), 4);
                }
            }
            c => self.0.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
        }
    }
}

/// Appends a text on one line. Every character that acts instead of being shown becomes `�`.
pub(crate) fn push_visible(out: &mut Vec<u8>, text: &str) {
    if text.bytes().all(|byte| matches!(byte, b' '..=b'~')) {
        out.extend_from_slice(text.as_bytes());
        return;
    }
    for c in text.chars() {
        let c = if acts(c) { char::REPLACEMENT_CHARACTER } else { c };
        out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pushed(push: impl FnOnce(&mut Vec<u8>)) -> String {
        let mut out = Vec::new();
        push(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn digits() {
        assert_eq!(pushed(|out| push_decimal(out, 0)), "0");
        assert_eq!(pushed(|out| push_decimal(out, u64::MAX)), u64::MAX.to_string());
        assert_eq!(pushed(|out| push_fraction(out, 42, 6)), "000042");
        assert_eq!(pushed(|out| push_fraction(out, 123_456_789, 9)), "123456789");
        assert_eq!(pushed(|out| push_six_digits(out, 12_345)), "012345");
        assert_eq!(pushed(|out| push_fraction(out, 1_234, 3)), "234");
        assert_eq!(pushed(|out| push_hex(out, &[0x0A, 0xFF], Some(b' '))), "0A FF");
        assert_eq!(pushed(|out| push_hex_number(out, 0x1234, 3)), "234");
        assert_eq!(pushed(|out| push_hex_number(out, 0x1BCD_EF01, 8)), "1BCDEF01");
        assert_eq!(pushed(|out| pad(out, 0, 70)).len(), 70);
    }

    proptest! {
        #[test]
        fn numbers_are_as_the_standard_library_writes_them(n: u64, bytes in prop::collection::vec(any::<u8>(), 0..70)) {
            for n in [n, n % 100, n % 1000, n % 100_000_000] {
                prop_assert_eq!(pushed(|out| push_decimal(out, n)), n.to_string());
                prop_assert_eq!(pushed(|out| push_fraction(out, n, 20)), format!("{n:020}"));
            }
            let digits: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
            prop_assert_eq!(pushed(|out| push_hex(out, &bytes, None)), digits.concat());
            prop_assert_eq!(pushed(|out| push_hex(out, &bytes, Some(b' '))), digits.join(" "));
        }

        #[test]
        fn json_strings_mean_the_text_and_show_nothing_that_acts(text in any::<String>()) {
            let json = pushed(|out| push_json_string(out, &text));
            prop_assert!(!json.contains(acts), "{json:?}");
            prop_assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
        }
    }
}
