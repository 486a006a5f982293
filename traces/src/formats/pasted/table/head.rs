//! The names of a table's columns, and the texts of its rows.

use crate::columns::{Radix, Unit};

/// The meaning of a column.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Field {
    Time(Option<Unit>),
    Date,
    Channel,
    Direction,
    /// The identifier, and its radix if the head names it.
    Id(Option<Radix>),
    Length,
    /// A length by a name that is no usual one for frames.
    Size,
    /// The number of bits of the identifier, or the kind of the frame, in words.
    Kind,
    /// Whether the identifier has 29 bits.
    Extended,
    Remote,
    Data,
    /// One byte of the data.
    Byte,
    Other,
}

/// The meaning of a column by its name.
pub(super) fn field(name: &[u8]) -> Field {
    let lower = name.to_ascii_lowercase();
    let bytes = trim(&lower);
    let (name, unit, radix) = split_unit(bytes);
    match name {
        b"id" | b"can id" | b"can-id" | b"can_id" | b"canid" | b"frame id" | b"frameid" | b"frame_id"
        | b"identifier" | b"message id" | b"msg id" | b"msgid" | b"arbitration id" | b"arbitration_id" | b"cob-id"
        | b"cobid" | b"arb id" | b"can_dataframe.id" => Field::Id(radix),
        b"size" => Field::Size,
        b"len"
        | b"dlc"
        | b"length"
        | b"data length"
        | b"data_length"
        | b"datalength"
        | b"dlen"
        | b"datalen"
        | b"can_dataframe.datalength" => Field::Length,
        b"data" | b"payload" | b"data bytes" | b"databytes" | b"data field" | b"can_dataframe.databytes" => Field::Data,
        b"time" | b"timestampepoch" | b"time stamp" | b"timestamp" | b"system time" | b"time offset" | b"abs time"
        | b"timestamps" => Field::Time(unit),
        b"date" => Field::Date,
        b"bus" | b"buschannel" | b"channel" | b"chn" | b"ch" | b"interface" | b"can_dataframe.buschannel" => {
            Field::Channel
        }
        b"dir" | b"direction" | b"rx/tx" | b"tx/rx" => Field::Direction,
        b"format" | b"type" | b"frame type" | b"frame format" | b"event type" | b"flags" | b"id type" => Field::Kind,
        b"extended" | b"ext" | b"ide" | b"is_extended" | b"is_extended_id" | b"extended id" | b"xtd"
        | b"can_dataframe.ide" => Field::Extended,
        b"remote" | b"rtr" | b"is_remote" | b"is_remote_frame" => Field::Remote,
        _ if is_byte_name(name) => Field::Byte,
        _ => Field::Other,
    }
}

/// The name without a detail in brackets, and the unit or radix that the detail names.
fn split_unit(name: &[u8]) -> (&[u8], Option<Unit>, Option<Radix>) {
    let Some(open) = name.iter().position(|byte| b"[(".contains(byte)) else { return (name, None, None) };
    let (before, inside) = name.split_at_checked(open).unwrap_or((name, &[]));
    if before.is_empty() {
        return (name, None, None);
    }
    let symbol = inside.get(1..inside.len().saturating_sub(1)).unwrap_or_default().trim_ascii();
    let radix = match symbol {
        b"hex" => Some(Radix::Hexadecimal),
        b"dec" => Some(Radix::Decimal),
        _ => None,
    };
    (before.trim_ascii_end(), Unit::by_symbol(if symbol == b"sec" { b"s" } else { symbol }), radix)
}

/// `d1`, `b0`, `byte 3`, `data0`.
fn is_byte_name(name: &[u8]) -> bool {
    let digits = name.iter().rev().take_while(|byte| byte.is_ascii_digit()).count();
    let stem = name.get(..name.len() - digits).unwrap_or_default().trim_ascii_end();
    (1..=2).contains(&digits) && matches!(stem, b"d" | b"b" | b"byte" | b"data" | b"db")
}

/// A text without blanks and quotes around it.
pub(super) fn trim(field: &[u8]) -> &[u8] {
    let is_around = |byte: &u8| b" \t\"'=".contains(byte);
    let start = field.iter().take_while(|byte| is_around(byte)).count();
    let end = field.len() - field.iter().rev().take_while(|byte| is_around(byte)).count();
    field.get(start..end).unwrap_or_default()
}

/// The fields of a row. A separator in quotes separates nothing.
pub(super) fn split(line: &[u8], separator: u8) -> impl Iterator<Item = &[u8]> {
    let mut is_quoted = false;
    line.split(move |byte| {
        is_quoted ^= *byte == b'"';
        *byte == separator && !is_quoted
    })
}
