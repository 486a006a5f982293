//! `frames`: the frames as they were recorded, not decoded.

use super::column::{Column, Rows};
use canvass_traces::{Channels, Direction, Frame, Record};

/// The columns of a frame, followed by further columns of the table.
macro_rules! frame_columns {
    ($($more:tt)*) => { $crate::columns![Self:
        "capture" name "the file" = |row, out| $crate::column::write_str(out, Some(row.capture));
        "number" u64 "its line, packet or message in the file, from 1" = |row| Some(row.record.place.number);
        "t" time "when it was seen" = |row| Some(row.record.timestamp);
        "channel" name "the channel's name" = |row, out| $crate::column::write_str(out, Some(row.channels.name(row.record.channel)));
        "can_id" u32 "the CAN-ID, 11 or 29 bits; of an error frame its class bits" = |row| Some($crate::frames::can_id(row.record));
        "extended" flag "whether the CAN-ID has 29 bits" = |row| Some($crate::frames::is_extended(&row.record.frame));
        "remote" flag "whether it is a remote frame" = |row| Some(row.record.frame.is_remote());
        "error" flag "whether it is an error frame" = |row| Some(row.record.frame.is_error());
        "fd" flag "whether it is a CAN FD frame" = |row| Some(row.record.frame.is_fd());
        "xl" flag "whether it is a CAN XL frame" = |row| Some(row.record.frame.is_xl());
        "length" u16 "bytes of payload; of a remote frame the length that it asks for" = |row| Some($crate::frames::length(row.record));
        "direction" word "`rx` or `tx`, where the capture says it" = |row| $crate::frames::direction(row.record);
        "data" bytes "the payload" = |row| Some(row.record.data());
        $($more)*
    ] };
}
pub(super) use frame_columns;

/// The rows of `frames`.
pub struct Frames;

/// A frame of a capture.
pub struct FrameRow<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The frame.
    pub record: &'a Record,
    /// The channels of the capture, with their names.
    pub channels: &'a Channels,
}

impl Rows for Frames {
    type Row<'a> = FrameRow<'a>;
    const COLUMNS: &'static [Column<Self>] = frame_columns![];
    const ALIKE: &'static [&'static str] = &["capture", "channel", "can_id", "extended", "remote", "error", "fd", "xl"];
}

/// The CAN-ID.
pub fn can_id(record: &Record) -> u64 {
    u64::from(record.frame.id().raw())
}

/// Whether the CAN-ID has 29 bits. Error frames have no CAN-ID.
pub fn is_extended(frame: &Frame) -> bool {
    frame.id().is_extended() && !frame.is_error()
}

/// The length of the payload; of a remote frame, the requested length.
pub fn length(record: &Record) -> u64 {
    record.frame.len() as u64
}

/// Whether the recorder sent or received the frame.
pub const fn direction(record: &Record) -> Option<&'static str> {
    match record.direction {
        Direction::Unknown => None,
        Direction::Rx => Some("rx"),
        Direction::Tx => Some("tx"),
    }
}
