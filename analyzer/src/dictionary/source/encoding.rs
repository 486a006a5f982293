//! Character sets: an EDS should be ASCII; in the field files are Latin-1, UTF-8 with and without byte order mark,
//! and UTF-16.

use std::borrow::Cow;

/// The character set of a file.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::dictionary) enum Encoding {
    Utf8,
    Utf8WithMark,
    Utf16LowFirst,
    Utf16HighFirst,
    Latin1,
}

/// A decoded file.
#[derive(Debug)]
pub(super) struct Decoded<'a> {
    pub text: Cow<'a, str>,
    pub encoding: Encoding,
    /// Bytes that are no character, each with its place in the text, where a replacement character stands for it.
    pub unread: Vec<(usize, Vec<u8>)>,
}

/// Decodes the file. Bytes that are no UTF-8 are read as Latin-1, in which every byte is a character.
pub(super) fn decode(bytes: &[u8]) -> Decoded<'_> {
    let exact = |text, encoding| Decoded { text, encoding, unread: Vec::new() };
    match bytes {
        [0xFF, 0xFE, text @ ..] => utf_16(text, Encoding::Utf16LowFirst),
        [0xFE, 0xFF, text @ ..] => utf_16(text, Encoding::Utf16HighFirst),
        [0xEF, 0xBB, 0xBF, text @ ..] => match std::str::from_utf8(text) {
            Ok(text) => exact(Cow::Borrowed(text), Encoding::Utf8WithMark),
            Err(_) => damaged_utf_8(text),
        },
        text => match std::str::from_utf8(text) {
            Ok(text) => exact(Cow::Borrowed(text), Encoding::Utf8),
            Err(_) => exact(Cow::Owned(text.iter().map(|&byte| char::from(byte)).collect()), Encoding::Latin1),
        },
    }
}

fn damaged_utf_8(bytes: &[u8]) -> Decoded<'_> {
    let (mut text, mut unread) = (String::with_capacity(bytes.len()), Vec::new());
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        if !chunk.invalid().is_empty() {
            unread.push((text.len(), chunk.invalid().to_vec()));
            text.push(char::REPLACEMENT_CHARACTER);
        }
    }
    Decoded { text: Cow::Owned(text), encoding: Encoding::Utf8WithMark, unread }
}

fn utf_16(bytes: &[u8], encoding: Encoding) -> Decoded<'_> {
    let (units, odd) = bytes.as_chunks::<2>();
    let (mut text, mut unread) = (String::with_capacity(units.len()), Vec::new());
    let is_low_first = encoding == Encoding::Utf16LowFirst;
    let unit = |&bytes: &[u8; 2]| if is_low_first { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) };
    for character in char::decode_utf16(units.iter().map(unit)) {
        text.push(character.unwrap_or_else(|alone| {
            let unit = alone.unpaired_surrogate();
            let bytes = if is_low_first { unit.to_le_bytes() } else { unit.to_be_bytes() };
            unread.push((text.len(), bytes.to_vec()));
            char::REPLACEMENT_CHARACTER
        }));
    }
    if !odd.is_empty() {
        unread.push((text.len(), odd.to_vec()));
    }
    Decoded { text: Cow::Owned(text), encoding, unread }
}

impl Encoding {
    /// The byte order mark.
    pub(super) const fn mark(self) -> &'static [u8] {
        match self {
            Self::Utf8 | Self::Latin1 => b"",
            Self::Utf8WithMark => b"\xEF\xBB\xBF",
            Self::Utf16LowFirst => b"\xFF\xFE",
            Self::Utf16HighFirst => b"\xFE\xFF",
        }
    }

    /// Appends the bytes of a text; `None` if Latin-1 lacks a character.
    pub(super) fn append(self, text: &str, bytes: &mut Vec<u8>) -> Option<()> {
        match self {
            Self::Utf8 | Self::Utf8WithMark => bytes.extend_from_slice(text.as_bytes()),
            Self::Utf16LowFirst => bytes.extend(text.encode_utf16().flat_map(u16::to_le_bytes)),
            Self::Utf16HighFirst => bytes.extend(text.encode_utf16().flat_map(u16::to_be_bytes)),
            Self::Latin1 => {
                for character in text.chars() {
                    bytes.push(u8::try_from(character).ok()?);
                }
            }
        }
        Some(())
    }

    /// Encodes a text; `None` if Latin-1 lacks a character.
    pub(in crate::dictionary) fn encode(self, text: &str) -> Option<Vec<u8>> {
        let mut bytes = self.mark().to_vec();
        self.append(text, &mut bytes)?;
        Some(bytes)
    }
}
