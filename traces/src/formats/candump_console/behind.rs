//! The text after the bytes of a frame on candump's console.

use super::start;
use crate::Record;
use crate::formats::pasted::remark;
use crate::grammar::{Expected, Parsed, hex_byte};

pub(super) const NO_SURPLUS: &str = "the end of the line after as many bytes as the brackets tell";

/// The text after the bytes of a frame.
#[derive(Clone, Copy)]
pub(super) enum Behind<'a> {
    /// Nothing, or a text that candump writes itself.
    Usual,
    /// Bytes beyond the length in brackets.
    Surplus(&'a [u8]),
    /// A text, with the mark before it.
    Remark(&'a [u8]),
}

/// The meaning of the text after `len` bytes; `last` is the text with the blanks before it.
#[cold]
pub(super) fn behind<'a>(last: &[u8], text: &'a [u8], len: usize) -> Parsed<'a, Behind<'a>> {
    match () {
        () if text.starts_with(b"ERRORFRAME") => Ok((text, Behind::Usual)),
        () if text.len() < last.len() && is_remark(text, len) => Ok((text, Behind::Remark(text))),
        () if is_bytes(text) => Ok((&[], Behind::Surplus(text))),
        () => Expected::fail(text, NO_SURPLUS),
    }
}

/// Whether somebody wrote this text after the bytes. Two lines that became one are no frame with a remark.
fn is_remark(text: &[u8], len: usize) -> bool {
    let is_marked = match text {
        [b'#' | b';' | b'<', ..] | [b'/', b'/' | b'*', ..] | [b'-', b'-' | b'>', ..] => true,
        // An arrow or a letter of another language: a damaged byte gives neither.
        [first, ..] if !first.is_ascii() => std::str::from_utf8(text).is_ok(),
        _ if b"ERRORFRAME".starts_with(text) => false,
        _ => len > 0 && begins_with_word(text),
    };
    let mut words = (0..text.len()).filter(|at| *at == 0 || text.get(at - 1) == Some(&b' '));
    is_marked && !words.any(|at| start(text.get(at..).unwrap_or_default()).is_ok_and(|(_, start)| start.brackets))
}

/// Whether the first word is no damaged byte.
fn begins_with_word(text: &[u8]) -> bool {
    let letters = text.iter().take_while(|byte| byte.is_ascii_alphabetic()).count();
    let word = text.get(..letters).unwrap_or_default();
    match word {
        [first, second, ..] if !first.is_ascii_hexdigit() && second.is_ascii_lowercase() => true,
        _ => letters >= 3 && !word.iter().all(u8::is_ascii_hexdigit),
    }
}

#[cold]
pub(super) fn remarked(record: Record, text: &[u8]) -> Record {
    match remark(text) {
        Some(remark) => record.with_comment(remark),
        None => record,
    }
}

/// Whether the rest of the line consists of two-digit bytes.
fn is_bytes(input: &[u8]) -> bool {
    let mut tokens = input.split(|byte| *byte == b' ').filter(|token| !token.is_empty());
    tokens.all(|token| matches!(hex_byte(token), Ok(([], _))))
}
