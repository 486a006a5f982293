//! Character sets: an EDS should be ASCII, the field has Latin-1, UTF-8 with and without byte order mark, and UTF-16.

use std::borrow::Cow;

use crate::dictionary::problem::{Place, Problems};
use crate::dictionary::rules::text as rules;

/// The text of the file. Bytes that are no UTF-8 are read as Latin-1, in which every byte is a character.
pub(in crate::dictionary) fn decode<'a>(bytes: &'a [u8], problems: &mut Problems) -> Cow<'a, str> {
    let mut report = |rule, found| {
        let place = Place { line: 1, ..Place::default() };
        problems.report(place, rule, "ASCII text without byte order mark", found);
    };
    match bytes {
        [0xFF, 0xFE, text @ ..] => {
            report(&rules::UTF_16, "UTF-16, low byte first");
            Cow::Owned(utf_16(text, u16::from_le_bytes))
        }
        [0xFE, 0xFF, text @ ..] => {
            report(&rules::UTF_16, "UTF-16, high byte first");
            Cow::Owned(utf_16(text, u16::from_be_bytes))
        }
        [0xEF, 0xBB, 0xBF, text @ ..] => {
            report(&rules::BYTE_ORDER_MARK, "UTF-8 with byte order mark");
            String::from_utf8_lossy(text)
        }
        text => match std::str::from_utf8(text) {
            Ok(text) => {
                if !text.is_ascii() {
                    report(&rules::ENCODING, "UTF-8");
                }
                Cow::Borrowed(text)
            }
            Err(_) => {
                report(&rules::ENCODING, "Latin-1");
                Cow::Owned(text.iter().map(|&byte| char::from(byte)).collect())
            }
        },
    }
}

fn utf_16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let (units, _) = bytes.as_chunks::<2>();
    char::decode_utf16(units.iter().map(|&bytes| unit(bytes)))
        .map(|character| character.unwrap_or(char::REPLACEMENT_CHARACTER))
        .collect()
}
