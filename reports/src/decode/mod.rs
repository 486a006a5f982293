//! Decoded frames, rendered one by one.
//!
//! Every rendering appends to a buffer that the caller writes out and clears: nothing is allocated per frame.

mod json;
mod text;

pub use json::JsonLines;
pub use text::{TextLines, TimeStyle};

use canvass_analyzer::{Meaning, network::Decoded};
use canvass_traces::{Channels, Record};

/// What a rendering needs of one frame.
pub struct Line<'a> {
    /// The frame.
    pub record: &'a Record,
    /// Its channel's name is among these.
    pub channels: &'a Channels,
    /// What the network made of it.
    pub decoded: &'a Decoded,
    /// What it means, in words.
    pub meaning: Meaning<'a>,
}

/// Renders decoded frames.
pub trait Lines {
    /// Appends the frame to `out`.
    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>);
}

const HEX: &[u8; 16] = b"0123456789ABCDEF";

/// Appends two digits for each byte, with `separator` between them.
fn push_hex(out: &mut Vec<u8>, bytes: &[u8], separator: Option<u8>) {
    for (n, &byte) in bytes.iter().enumerate() {
        if n > 0 {
            out.extend(separator);
        }
        out.extend_from_slice(&[HEX[usize::from(byte >> 4)], HEX[usize::from(byte & 15)]]);
    }
}

/// Appends a decimal number.
fn push_decimal(out: &mut Vec<u8>, mut n: u64) {
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

/// Appends the last `width` decimal digits of a number.
fn push_fraction(out: &mut Vec<u8>, mut n: u64, width: usize) {
    let mut digits = [b'0'; 20];
    for digit in digits[..width].iter_mut().rev() {
        *digit = b'0' + (n % 10) as u8;
        n /= 10;
    }
    out.extend_from_slice(&digits[..width]);
}

/// Fills up with blanks to `width` columns from `start`.
fn pad(out: &mut Vec<u8>, start: usize, width: usize) {
    let written = out.len() - start;
    out.resize(out.len() + width.saturating_sub(written), b' ');
}

#[cfg(test)]
mod tests {
    use super::*;

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
    }
}
