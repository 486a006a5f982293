//! The interface of all capture readers.

use crate::{Channels, Columns, Damage, Format, Record, SkipSet};

/// Reads a capture, one record or damage after the other, in the order of the source.
///
/// After the end, or after a [fatal](crate::DamageKind::is_fatal) damage, `next` always returns `None`.
pub trait Reader: Send + Iterator<Item = Result<Record, Damage>> {
    /// The channels seen so far; every record's channel is among them.
    fn channels(&self) -> &Channels;

    /// The origin of the timestamps, as far as it is known.
    fn time_base(&self) -> TimeBase;

    /// The bit rate of the bus in bit/s, if the source gives it.
    fn bit_rate(&self) -> Option<u32> {
        None
    }

    /// How the columns of the source are read, if that was inferred from its content.
    fn interpretation(&self) -> Option<String> {
        None
    }

    /// Writes the next item that is not skipped into `record`; this saves moving it from reader to reader. After many
    /// skipped records the next record is returned even if the set has it, so that the caller gets control from time to
    /// time.
    fn next_kept(&mut self, skip: &mut SkipSet, record: &mut Record) -> Option<Result<(), Damage>> {
        for _ in 0..SkipSet::IN_A_ROW {
            match self.next()? {
                Ok(next) if skip.skips(&next) => {}
                item => return Some(item.map(|next| *record = next)),
            }
        }
        Some(self.next()?.map(|next| *record = next))
    }
}

/// Options for reading a capture.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The format; `None` to recognise the format by the content.
    pub format: Option<Format>,
    /// The topics to read, in formats with topics (MCAP); empty for all topics with CAN frames.
    pub topics: Vec<String>,
    /// The meaning of the columns of [`Format::Pasted`]; `None` to infer it from the content.
    pub columns: Option<Columns>,
}

/// The origin of a capture's timestamps.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum TimeBase {
    /// 1970-01-01 00:00:00 UTC.
    #[default]
    Utc,
    /// 1970-01-01 00:00:00 in the recorder's local time, of an unknown zone.
    Local,
    /// The start of the recording, at an unknown date.
    Start,
    /// No origin: the source has no times, and all are zero.
    None,
}

impl std::fmt::Display for TimeBase {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Utc => "1970 in UTC",
            Self::Local => "1970 in local time",
            Self::Start => "the start of the recording",
            Self::None => "nothing",
        })
    }
}
