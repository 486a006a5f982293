//! The interface of all capture writers.

use crate::{Channels, Format, Record};
use std::collections::BTreeMap;
use std::io;

/// Writes a capture, record by record.
pub trait Writer {
    /// Writes one record. `channels` has the name of its channel.
    ///
    /// Properties that the format can't hold are left out and [counted](Writer::losses).
    ///
    /// # Errors
    /// The sink's error.
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError>;

    /// Writes all buffered data, so that a reader sees every record written so far.
    ///
    /// # Errors
    /// The sink's error.
    fn flush(&mut self) -> Result<(), WriteError>;

    /// Writes the end of the file. Nothing may be written after it.
    ///
    /// # Errors
    /// The sink's error.
    fn finish(&mut self) -> Result<(), WriteError>;

    /// The losses so far.
    fn losses(&self) -> &Losses;

    /// The first bytes of the finished file, if the format states there what is known only at the end, such as the
    /// file's size. The caller writes them over the beginning of the file. Without them a reader may take the file for
    /// unfinished.
    fn beginning(&self) -> Option<&[u8]> {
        None
    }
}

/// Why a capture can't be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file, pipe or disk fails.
    #[error("can't write: {0}")]
    Io(#[from] io::Error),
    /// The format can only be read.
    #[error("{0} can be read, but not written")]
    NotWritten(Format),
    /// The format's library reports another error.
    #[error("can't write {format}: {reason}")]
    Format {
        /// The format.
        format: Format,
        /// The library's message.
        reason: String,
    },
}

/// Options for writing a capture.
#[derive(Clone, Debug, Default)]
pub struct WriteOptions {
    /// The origin of the records' timestamps: some formats hold a date, or note that there is none.
    pub time_base: crate::TimeBase,
    /// The compression of chunks, in formats with chunks (MCAP).
    pub chunk_compression: ChunkCompression,
    /// Whether the caller flushes after every record. Formats with chunks then write no chunks: each record would be a
    /// chunk of its own, and each chunk needs a row of the index and memory for it.
    pub live: bool,
}

/// The compression of a written file's chunks.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum ChunkCompression {
    /// zstd, which makes small files.
    #[default]
    Zstd,
    /// lz4, which is fast.
    Lz4,
    /// No compression.
    None,
}

/// The properties that a format can't hold, each with the number of records that lost it.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Losses(BTreeMap<Loss, u64>);

/// A property of a record that a format can't hold.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Loss {
    /// The whole frame: the format does not know its kind (such as CAN XL).
    Frame,
    /// The channel's name (the format may hold a number instead).
    ChannelName,
    /// The direction: whether the frame was sent or received.
    Direction,
    /// The last digits of the time.
    TimeResolution,
    /// The date: the format holds only the time since the start.
    Date,
    /// The fact that the date is unknown: times since the start of the recording become dates in 1970.
    UnknownDate,
    /// The time zone: whether the date is in UTC or in local time.
    TimeZone,
    /// The flags BRS and ESI of a CAN FD frame.
    FdFlags,
    /// A data length code above 8 of a classical frame.
    RawDlc,
    /// The requested length of a remote frame.
    RemoteLength,
    /// The class or the detail bytes of an error frame.
    ErrorDetail,
    /// The comment before a frame.
    Comment,
}

impl Losses {
    /// Counts one record with this loss; does nothing for `None`.
    pub(crate) fn count_any(&mut self, loss: Option<Loss>) {
        if let Some(loss) = loss {
            self.count(loss);
        }
    }

    /// Counts one record with this loss.
    pub fn count(&mut self, loss: Loss) {
        *self.0.entry(loss).or_default() += 1;
    }

    /// The losses, each with its number of records.
    pub fn iter(&self) -> impl Iterator<Item = (Loss, u64)> {
        self.0.iter().map(|(&loss, &n)| (loss, n))
    }

    /// Whether there is no loss.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Loss {
    /// The loss if times with origin `base` are written to a format whose times count from 1970 in UTC.
    pub(crate) const fn of_utc(base: crate::TimeBase) -> Option<Self> {
        match base {
            crate::TimeBase::Utc => None,
            crate::TimeBase::Local => Some(Self::TimeZone),
            crate::TimeBase::Start | crate::TimeBase::None => Some(Self::UnknownDate),
        }
    }

    /// The name of the loss.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Frame => "frames of a kind that the format does not know",
            Self::ChannelName => "channel names",
            Self::Direction => "directions",
            Self::TimeResolution => "digits of the time",
            Self::Date => "the date",
            Self::UnknownDate => "the fact that the date is unknown (times become times of 1970)",
            Self::TimeZone => "the time zone (UTC or local)",
            Self::FdFlags => "flags of CAN FD frames",
            Self::RawDlc => "data length codes above 8",
            Self::RemoteLength => "requested lengths of remote frames",
            Self::ErrorDetail => "details of error frames",
            Self::Comment => "comments",
        }
    }
}
