//! What every capture reader does.

use crate::{Channels, Damage, Format, Record, SkipSet};

/// Reads a capture, one record or damage after the other, in the order of the source.
///
/// After a [fatal](crate::DamageKind::is_fatal) damage, and at the end, `next` returns `None` for ever.
pub trait Reader: Iterator<Item = Result<Record, Damage>> {
    /// The channels seen so far; every record's channel is among them.
    fn channels(&self) -> &Channels;

    /// What the timestamps count from, as far as the source has shown.
    fn time_base(&self) -> TimeBase;

    /// The bit rate of the bus in bit/s, where the source says it.
    fn bit_rate(&self) -> Option<u32> {
        None
    }

    /// What comes next, written into `record`, which saves moving it from reader to reader. Records that are skipped are not
    /// given, but one of many, so that whoever waits can do something else.
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

/// How to read a capture.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The format, where the user says it; else it is recognised by the content.
    pub format: Option<Format>,
    /// The topics to read, where the format has topics (MCAP); empty for all that carry CAN frames.
    pub topics: Vec<String>,
}

/// What the timestamps of a capture count from.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum TimeBase {
    /// 1970-01-01 00:00:00 UTC.
    #[default]
    Utc,
    /// 1970-01-01 00:00:00 in the recorder's local time, whose zone the source does not tell.
    Local,
    /// The start of the recording, at a date that the source does not tell.
    Start,
    /// Nothing: the source has no times, and all are zero.
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
