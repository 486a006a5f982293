//! What every capture writer does.

use crate::{Channels, Format, Record};
use std::collections::BTreeMap;
use std::io;

/// Writes a capture, record by record.
pub trait Writer {
    /// Writes one record; its channel is named in `channels`.
    ///
    /// What the format can't hold is written as far as it can be, and [counted](Writer::losses).
    ///
    /// # Errors
    /// What the sink reports.
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError>;

    /// Writes what is still held back, so that a reader sees all that was written so far.
    ///
    /// # Errors
    /// What the sink reports.
    fn flush(&mut self) -> Result<(), WriteError>;

    /// Writes the end of the file. Nothing may be written after it.
    ///
    /// # Errors
    /// What the sink reports.
    fn finish(&mut self) -> Result<(), WriteError>;

    /// What the format could not hold, so far.
    fn losses(&self) -> &Losses;
}

/// Why a capture can't be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file, pipe or disk fails.
    #[error("can't write: {0}")]
    Io(#[from] io::Error),
    /// The format can only be read.
    #[error("{0} is read, but not written")]
    NotWritten(Format),
    /// The format's library reports something else.
    #[error("can't write {format}: {reason}")]
    Format {
        /// The format.
        format: Format,
        /// The library's words.
        reason: String,
    },
}

/// How to write a capture.
#[derive(Clone, Debug, Default)]
pub struct WriteOptions {
    /// What the records' timestamps count from: some formats hold a date, or say that there is none.
    pub time_base: crate::TimeBase,
    /// How chunks are compressed, in formats that have them (MCAP).
    pub chunk_compression: ChunkCompression,
    /// Every record will be flushed: formats with chunks write none, as each of one record would take its place in the
    /// index, and the memory that this needs.
    pub live: bool,
}

/// How the chunks of a written file are compressed.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum ChunkCompression {
    /// By zstd: small.
    #[default]
    Zstd,
    /// By lz4: fast.
    Lz4,
    /// Not at all.
    None,
}

/// What a format can't hold, each with the number of records that it was lost of.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Losses(BTreeMap<Loss, u64>);

/// Something that a record has and a format can't hold.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Loss {
    /// The whole frame: a kind that the format does not know (such as CAN XL).
    Frame,
    /// The channel's name (a number may have taken its place).
    ChannelName,
    /// Whether the frame was sent or received.
    Direction,
    /// The last digits of the time.
    TimeResolution,
    /// The date: only the time since the start is held.
    Date,
    /// That the date is not known: times that count from the start of the recording become times in 1970.
    UnknownDate,
    /// Whether the date is in UTC or in local time.
    TimeZone,
    /// The flags BRS and ESI of a CAN FD frame.
    FdFlags,
    /// A data length code above 8 of a classical frame.
    RawDlc,
    /// The length that a remote frame asks for.
    RemoteLength,
    /// The class or the detail bytes of an error frame.
    ErrorDetail,
    /// What the capture says before a frame.
    Comment,
}

impl Losses {
    /// Counts one record that lost this, if it lost anything.
    pub(crate) fn count_any(&mut self, loss: Option<Loss>) {
        if let Some(loss) = loss {
            self.count(loss);
        }
    }

    /// Counts one record that lost this.
    pub fn count(&mut self, loss: Loss) {
        *self.0.entry(loss).or_default() += 1;
    }

    /// What was lost, and of how many records.
    pub fn iter(&self) -> impl Iterator<Item = (Loss, u64)> {
        self.0.iter().map(|(&loss, &n)| (loss, n))
    }

    /// Whether everything was held.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Loss {
    /// What is lost of times that count from `base` in a format that counts them from 1970 in UTC.
    pub(crate) const fn of_utc(base: crate::TimeBase) -> Option<Self> {
        match base {
            crate::TimeBase::Utc => None,
            crate::TimeBase::Local => Some(Self::TimeZone),
            crate::TimeBase::Start | crate::TimeBase::None => Some(Self::UnknownDate),
        }
    }

    /// What was lost, in words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frame => "frames of a kind that the format does not know",
            Self::ChannelName => "channel names",
            Self::Direction => "directions",
            Self::TimeResolution => "digits of the time",
            Self::Date => "the date",
            Self::UnknownDate => "that the date is not known (times become times of 1970)",
            Self::TimeZone => "the time zone (UTC or local)",
            Self::FdFlags => "flags of CAN FD frames",
            Self::RawDlc => "data length codes above 8",
            Self::RemoteLength => "lengths that remote frames ask for",
            Self::ErrorDetail => "details of error frames",
            Self::Comment => "comments",
        }
    }
}
