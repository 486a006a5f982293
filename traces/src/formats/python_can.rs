//! Messages as python-can stores them in its own formats, CSV and SQLite: time, identifier, kind, length and data, without
//! channel and direction.

use crate::formats::candump_log::EPOCH_FROM;
use crate::{CanId, ChannelId, ErrorClass, Flags, Frame, Record, TimeBase, Timestamp};

/// The name of the only channel.
pub(super) const CHANNEL: &str = "1";

/// A message whose fields are not checked yet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Message<'a> {
    pub nanos: u64,
    pub id: u32,
    pub extended: bool,
    pub remote: bool,
    pub error: bool,
    /// Number of bytes. More than 8 are CAN FD.
    pub length: u64,
    pub data: &'a [u8],
}

/// The field that can't be.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Wrong {
    /// The identifier.
    Id,
    /// There are fewer bytes than the length says.
    Missing,
    /// There are more bytes than the length says.
    More,
    /// CAN FD has no such length.
    FdLength,
    /// A frame with so many bytes can't be of this kind.
    Length,
}

impl Wrong {
    /// What would be right.
    pub const fn expected(self) -> &'static str {
        match self {
            Self::Id => "an id of 11 bits, or of 29 bits where the next column is 1",
            Self::Missing | Self::More => "as many bytes as the length says",
            Self::FdLength => "a length that CAN FD has",
            Self::Length => "at most 8 bytes",
        }
    }
}

impl Message<'_> {
    /// The record of the message.
    pub fn record(self) -> Result<Record, Wrong> {
        let Self { nanos, id, extended, remote, error, length, data } = self;
        let carried = if remote { 0 } else { length };
        match data.len() as u64 {
            found if found < carried => return Err(Wrong::Missing),
            found if found > carried => return Err(Wrong::More),
            _ => {}
        }
        let can_id = if extended { CanId::extended(id) } else { CanId::standard(id) };
        let frame = match (error, can_id) {
            // The id of an error frame is its class; the other columns are ignored.
            (true, _) if id <= CanId::MAX_EXTENDED => Frame::error(ErrorClass(id), data),
            (false, Some(id)) if remote => u8::try_from(length).ok().and_then(|length| Frame::remote(id, length)),
            (false, Some(id)) if length > 8 => {
                let record = Record::fd(Timestamp(nanos), ChannelId(0), id, Flags::NONE, data);
                return record.ok_or(Wrong::FdLength);
            }
            (false, Some(id)) => Frame::new(id, data),
            _ => return Err(Wrong::Id),
        };
        frame.map(|frame| Record::new(Timestamp(nanos), ChannelId(0), frame)).ok_or(Wrong::Length)
    }
}

/// The origin of the times of a file whose first time this is: they count from 1970 or, if below 1973, from the start.
pub(super) const fn time_base(first: Timestamp) -> TimeBase {
    if first.nanos() < EPOCH_FROM { TimeBase::Start } else { TimeBase::Utc }
}
