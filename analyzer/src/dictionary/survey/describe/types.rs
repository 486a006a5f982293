//! The data type of an entry: the standard's type if it fits, else a type of the value's length.

use super::{Facts, Guess};
use crate::dictionary::data_type::{DataClass, DataType};
use crate::dictionary::survey::Answer;
use crate::identity::Multiplexer;

/// The data type, and whether it is guessed. `counts`: the entry is the count of an object's entries.
pub(super) fn of(facts: &Facts<'_>, at: Multiplexer, counts: bool) -> (DataType, Option<Guess>) {
    let standard = facts.standard(at).and_then(|name| name.entry).and_then(|entry| entry.data_type);
    let bytes = match facts.survey.get(at) {
        Some(Answer::Value(bytes)) => bytes,
        Some(Answer::Long(most)) => {
            let fits = standard.filter(|data_type| data_type.bytes().is_none());
            return fits.map_or((DataType::DOMAIN, Some(Guess::TypeOf(*most))), |data_type| (data_type, None));
        }
        _ => return standard.map_or((DataType::UNSIGNED32, Some(Guess::Type)), |data_type| (data_type, None)),
    };
    match standard {
        Some(data_type) if data_type.bytes().is_none_or(|length| length == bytes.len()) => (data_type, None),
        Some(data_type) => (of_length(data_type, bytes), Some(Guess::TypeBeside(bytes.len()))),
        None if counts && bytes.len() == 1 => (DataType::UNSIGNED8, None),
        None => (by_content(bytes), Some(Guess::TypeOf(bytes.len()))),
    }
}

/// The type with the value's length that is closest to the standard's type: later versions of a profile have longer
/// values.
fn of_length(standard: DataType, bytes: &[u8]) -> DataType {
    let same = |data_type: &&DataType| data_type.class() == standard.class() && data_type.bytes() == Some(bytes.len());
    match standard.class() {
        Some(DataClass::Integer | DataClass::Unsigned) => DataType::ALL.iter().find(same).copied(),
        _ => None,
    }
    .unwrap_or_else(|| by_content(bytes))
}

/// The type guessed from the bytes: integers have one, two, four or eight bytes; printable bytes are a text.
fn by_content(bytes: &[u8]) -> DataType {
    match bytes.len() {
        1 => DataType::UNSIGNED8,
        2 => DataType::UNSIGNED16,
        4 => DataType::UNSIGNED32,
        _ if is_text(bytes) => DataType::VISIBLE_STRING,
        8 => DataType::UNSIGNED64,
        _ => DataType::DOMAIN,
    }
}

/// Whether the bytes are printable characters, followed by zeros.
fn is_text(bytes: &[u8]) -> bool {
    let zeros = bytes.iter().rev().take_while(|&&byte| byte == 0).count();
    let text = bytes.get(..bytes.len() - zeros).unwrap_or_default();
    !text.is_empty() && text.iter().all(|byte| matches!(byte, b' '..=b'~'))
}
