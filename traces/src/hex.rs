//! Bytes in hexadecimal, two upper-case digits each.

use crate::grammar::nibble;
use std::fmt;

/// Bytes with spaces between them: `01 7F`.
///
/// ```
/// assert_eq!(canvass_traces::hex::spaced(&[1, 0x7F]).to_string(), "01 7F");
/// ```
pub fn spaced(bytes: &[u8]) -> impl fmt::Display + '_ {
    fmt::from_fn(move |f| {
        bytes.iter().enumerate().try_for_each(|(position, &byte)| {
            if position > 0 {
                f.write_str(" ")?;
            }
            write_hex(f, byte)
        })
    })
}

/// Bytes without spaces, as in files and command lines: `017F`.
///
/// ```
/// assert_eq!(canvass_traces::hex::compact(&[1, 0x7F]).to_string(), "017F");
/// ```
pub fn compact(bytes: &[u8]) -> impl fmt::Display + '_ {
    fmt::from_fn(move |f| bytes.iter().try_for_each(|&byte| write_hex(f, byte)))
}

/// Parses the digits of [`compact`], in upper or lower case; `None` for any other character or an odd number of digits.
///
/// ```
/// assert_eq!(canvass_traces::hex::parse("017f"), Some(vec![1, 0x7F]));
/// assert_eq!(canvass_traces::hex::parse("017"), None);
/// ```
pub fn parse(digits: impl AsRef<[u8]>) -> Option<Vec<u8>> {
    let byte = |pair: &[u8]| match pair {
        &[high, low] => Some(nibble(high)? << 4 | nibble(low)?),
        _ => None,
    };
    digits.as_ref().chunks(2).map(byte).collect()
}

/// Writes a byte as two digits, without the slower formatter.
pub(crate) fn write_hex(out: &mut impl fmt::Write, byte: u8) -> fmt::Result {
    const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
    out.write_char(char::from(DIGITS[usize::from(byte >> 4)]))?;
    out.write_char(char::from(DIGITS[usize::from(byte & 15)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn no_bytes_are_no_digits() {
        assert_eq!(
            (spaced(&[]).to_string(), compact(&[]).to_string(), parse("")),
            (String::new(), String::new(), Some(vec![]))
        );
    }

    #[test]
    fn what_is_no_pair_of_digits_is_refused() {
        for text in ["0", "0x", "+1", "-1", " 1", "1 ", "01 02", "0g", "é"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }

    proptest! {
        #[test]
        fn digits_are_as_the_standard_library_writes_them(bytes in prop::collection::vec(any::<u8>(), 0..70)) {
            let digits: Vec<String> = bytes.iter().map(|byte| format!("{byte:02X}")).collect();
            prop_assert_eq!(spaced(&bytes).to_string(), digits.join(" "));
            prop_assert_eq!(compact(&bytes).to_string(), digits.concat());
            prop_assert_eq!(parse(digits.concat()), Some(bytes.clone()));
            prop_assert_eq!(parse(digits.concat().to_lowercase()), Some(bytes));
        }
    }
}
