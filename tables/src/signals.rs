//! `signals`: the values of process data, one row each.

use super::column::{Column, Rows, write, write_str};
use super::decoded_frame::DecodedFrame;
use super::messages::{node, pdo};
use crate::columns;
use canvass_analyzer::{Number, SignalValue};

/// The rows of `signals`.
pub struct Signals;

/// A value in a PDO or SRDO.
pub struct SignalRow<'a> {
    /// The frame that carries the value.
    pub frame: DecodedFrame<'a>,
    /// The value.
    pub signal: &'a SignalValue<'a>,
}

impl Rows for Signals {
    type Row<'a> = SignalRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "capture" name "the file" = |row, out| write_str(out, Some(row.frame.capture));
        "number" u64 "the frame's line, packet or message in the file, from 1" = |row| Some(row.frame.record.place.number);
        "t" time "when the frame was seen" = |row| Some(row.frame.record.timestamp);
        "channel" name "the channel's name" = |row, out| write_str(out, Some(row.frame.channels.name(row.frame.record.channel)));
        "can_id" u32 "the frame's CAN-ID" = |row| Some(super::frames::can_id(row.frame.record));
        "service" word "`pdo` or `srdo`" = |row| Some(row.frame.decoded.service.name());
        "node" u8 "the node whose process data they are" = |row| node(row.frame.decoded);
        "pdo" name "which PDO: `TPDO 1`" = |row, out| write(out, pdo(&row.frame.decoded.message));
        "index" u16 "the mapped object" = |row| Some(u64::from(row.signal.multiplexer().index.0));
        "sub" u8 "its sub-index" = |row| Some(u64::from(row.signal.multiplexer().sub.0));
        "name" name "the object's name" = |row, out| write(out, row.signal.name());
        "type" word "what `raw` is: `boolean`, `integer`, `unsigned`, `real32`, `real64`" = |row| row.signal.raw.map(type_name);
        "raw" i64 "the number in the frame; null of REAL32 and REAL64, whose number is `value`, and of UNSIGNED64 from 2^63" = |row| row.signal.raw.and_then(whole);
        "value" f64 "the value in `unit`" = |row| row.signal.value().map(|(value, _)| value.as_f64());
        "unit" name "the unit that the standard or the description gives" = |row, out| match row.signal.value() {
            Some((_, unit)) => write_str(out, unit.as_ref().map(|unit| &*unit.symbol)),
            None => false,
        };
        "scaled" f64 "the value in `scaled_unit`, where the device's configuration tells it" = |row| row.signal.scaled().map(|(value, _)| value.as_f64());
        "scaled_unit" name "such as degrees" = |row, out| write_str(out, row.signal.scaled().map(|(_, unit)| &*unit.symbol));
    ];
    const ALIKE: &'static [&'static str] =
        &["capture", "channel", "can_id", "service", "node", "pdo", "index", "sub", "name"];
}

/// The name of the number's type.
const fn type_name(number: Number) -> &'static str {
    match number {
        Number::Boolean(_) => "boolean",
        Number::Integer(_) => "integer",
        Number::Unsigned(_) => "unsigned",
        Number::Real32(_) => "real32",
        Number::Real64(_) => "real64",
    }
}

/// The number as a signed integer, if it is one and fits.
fn whole(number: Number) -> Option<i64> {
    match number {
        Number::Boolean(value) => Some(i64::from(value)),
        Number::Integer(value) => Some(value),
        Number::Unsigned(value) => i64::try_from(value).ok(),
        Number::Real32(_) | Number::Real64(_) => None,
    }
}
