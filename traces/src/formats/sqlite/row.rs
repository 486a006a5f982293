//! Rows: their columns, and numbers of variable length.

use crate::damage::Flaw;

/// The value of a column.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Value<'a> {
    Null,
    Integer(i64),
    Real(f64),
    Blob(&'a [u8]),
    Text(&'a [u8]),
}

/// Splits a number of variable length off: seven bits in each byte, eight in the ninth.
pub(super) fn varint(bytes: &[u8]) -> Option<(u64, &[u8])> {
    let mut value = 0_u64;
    for (n, &byte) in bytes.iter().take(9).enumerate() {
        if n == 8 {
            return Some((value << 8 | u64::from(byte), &bytes[9..]));
        }
        value = value << 7 | u64::from(byte & 0x7F);
        if byte < 0x80 {
            return Some((value, &bytes[n + 1..]));
        }
    }
    None
}

/// The columns of a row: first a header with the type of each, then the values.
pub(super) fn columns(row: &[u8]) -> Result<Vec<Value<'_>>, Flaw> {
    let cut = || Flaw::malformed("a row with all of its columns", format!("{} bytes", row.len()));
    let (length, _) = varint(row).ok_or_else(cut)?;
    let length = usize::try_from(length).ok().filter(|length| *length <= row.len()).ok_or_else(cut)?;
    let (_, mut types) = varint(&row[..length]).ok_or_else(cut)?;
    let mut values = &row[length..];
    let mut columns = Vec::new();
    while !types.is_empty() {
        let (kind, rest) = varint(types).ok_or_else(cut)?;
        let (value, after) = value(kind, values).ok_or_else(cut)?;
        columns.push(value);
        (types, values) = (rest, after);
    }
    Ok(columns)
}

/// Splits a value of this type off.
fn value(kind: u64, bytes: &[u8]) -> Option<(Value<'_>, &[u8])> {
    let integer = |length| {
        let (value, rest) = bytes.split_at_checked(length)?;
        let sign = if value[0] & 0x80 != 0 { -1_i64 } else { 0 };
        Some((Value::Integer(value.iter().fold(sign, |number, &byte| number << 8 | i64::from(byte))), rest))
    };
    match kind {
        0 => Some((Value::Null, bytes)),
        1..=4 => integer(kind as usize),
        5 => integer(6),
        6 => integer(8),
        7 => {
            let (value, rest) = bytes.split_first_chunk::<8>()?;
            Some((Value::Real(f64::from_be_bytes(*value)), rest))
        }
        8 | 9 => Some((Value::Integer(kind as i64 - 8), bytes)),
        10 | 11 => None,
        _ => {
            let (value, rest) = bytes.split_at_checked(usize::try_from((kind - 12) / 2).ok()?)?;
            Some((if kind.is_multiple_of(2) { Value::Blob(value) } else { Value::Text(value) }, rest))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_variable_length() {
        assert_eq!(varint(b"\x05rest"), Some((5, &b"rest"[..])));
        assert_eq!(varint(b"\x81\x00"), Some((128, &b""[..])));
        assert_eq!(varint(&[0xFF; 9]), Some((u64::MAX, &b""[..])));
        assert_eq!(varint(&[0xFF; 8]), None);
        assert_eq!(varint(b""), None);
    }

    #[test]
    fn columns_of_every_type() {
        let row = b"\x08\x00\x01\x02\x08\x09\x10\x11\xFF\x01\x00abab";
        let expected = [
            Value::Null,
            Value::Integer(-1),
            Value::Integer(256),
            Value::Integer(0),
            Value::Integer(1),
            Value::Blob(b"ab"),
            Value::Text(b"ab"),
        ];
        assert_eq!(columns(row).unwrap(), expected);
        let mut real = b"\x02\x07".to_vec();
        real.extend(1.5_f64.to_be_bytes());
        assert_eq!(columns(&real).unwrap(), [Value::Real(1.5)]);
        for cut in 0..row.len() {
            assert!(columns(&row[..cut]).is_err(), "{cut}");
        }
        assert!(columns(b"\x02\x0A").is_err(), "a type that SQLite reserves");
    }
}
