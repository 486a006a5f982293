//! Numbers and strings appended to a buffer, without allocating.

use crate::escape::acts;
use canvass_analyzer::Meaning;
use std::fmt::{self, Display, Write as _};

pub const HEX: &[u8; 16] = b"0123456789ABCDEF";

/// Appends two digits for each byte, with `separator` between them.
pub fn push_hex(out: &mut Vec<u8>, bytes: &[u8], separator: Option<u8>) {
    // Eight bytes at a time: growing the buffer costs more than the digits.
    for (n, eight) in bytes.chunks(8).enumerate() {
        if n > 0 {
            out.extend(separator);
        }
        let mut digits = [separator.unwrap_or_default(); 24];
        let width = if separator.is_some() { 3 } else { 2 };
        for (at, &byte) in eight.iter().enumerate() {
            digits[width * at] = HEX[usize::from(byte >> 4)];
            digits[width * at + 1] = HEX[usize::from(byte & 15)];
        }
        out.extend_from_slice(&digits[..(width * eight.len()).saturating_sub(width - 2)]);
    }
}

/// Appends the lower `digits` (at most 8) hexadecimal digits of a number.
pub fn push_hex_number(out: &mut Vec<u8>, number: u32, digits: usize) {
    let mut shown = [0; 8];
    let digits = digits.min(shown.len());
    for (n, digit) in shown[..digits].iter_mut().rev().enumerate() {
        *digit = HEX[(number >> (4 * n) & 15) as usize];
    }
    out.extend_from_slice(&shown[..digits]);
}

/// Appends a decimal number.
pub fn push_decimal(out: &mut Vec<u8>, mut n: u64) {
    let mut digits = [0; 20];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (n % 10) as u8;
        n /= 10;
        if n == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
}

/// Appends the last `width` (at most 20) decimal digits of a number.
pub fn push_fraction(out: &mut Vec<u8>, mut n: u64, width: usize) {
    let mut digits = [b'0'; 20];
    for digit in digits[..width].iter_mut().rev() {
        *digit = b'0' + (n % 10) as u8;
        n /= 10;
    }
    out.extend_from_slice(&digits[..width]);
}

/// Fills up with blanks to `width` columns from `start`.
pub fn pad(out: &mut Vec<u8>, start: usize, width: usize) {
    let written = out.len() - start;
    out.resize(out.len() + width.saturating_sub(written), b' ');
}

/// Appends a text.
pub fn push_text(out: &mut Vec<u8>, text: impl Display) {
    // Writing to a vector can't fail.
    let _ = write!(Bytes(out), "{text}");
}

/// A buffer of bytes that texts are written to.
struct Bytes<'a>(&'a mut Vec<u8>);

impl fmt::Write for Bytes<'_> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.extend_from_slice(text.as_bytes());
        Ok(())
    }
}

/// Appends what a frame means.
pub fn push_meaning(out: &mut Vec<u8>, meaning: &Meaning<'_>) {
    match meaning.fixed() {
        Some(text) => out.extend_from_slice(text.as_bytes()),
        None => push_text(out, meaning),
    }
}

/// Appends a JSON string. Characters that act instead of being shown are escaped, as all that JSON forbids.
pub fn push_json_string(out: &mut Vec<u8>, text: impl Display) {
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

/// Appends a text on one line: every character that acts instead of being shown becomes `�`.
pub fn push_visible(out: &mut Vec<u8>, text: &str) {
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
        assert_eq!(pushed(|out| push_hex(out, &[0x0A, 0xFF], Some(b' '))), "0A FF");
        assert_eq!(pushed(|out| push_hex_number(out, 0x1234, 3)), "234");
    }

    proptest! {
        #[test]
        fn json_strings_mean_the_text_and_show_nothing_that_acts(text in any::<String>()) {
            let json = pushed(|out| push_json_string(out, &text));
            prop_assert!(!json.contains(acts), "{json:?}");
            prop_assert_eq!(serde_json::from_str::<String>(&json).unwrap(), text);
        }
    }
}
