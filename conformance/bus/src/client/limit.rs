//! Limits of one upload: a faulty or hostile server may announce 4 GiB, or send segments without end.

use canvass_traces::Duration;
use std::fmt;

/// The limits of one upload.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct UploadLimit {
    /// Maximum number of bytes of the value.
    pub bytes: usize,
    /// Maximum time from the request to the last segment; without it, empty segments could go on for ever.
    pub time: Duration,
}

impl UploadLimit {
    /// The limit of each upload when a whole dictionary is read: longer values are programs and logs, whose content
    /// says little about the object.
    pub const OF_MANY: Self = Self { bytes: 64 << 10, time: Duration::from_secs(30) };
}

/// The limit for a single object: a program of 1 MiB takes six minutes at 125 kbit/s.
impl Default for UploadLimit {
    fn default() -> Self {
        Self { bytes: 16 << 20, time: Duration::from_secs(600) }
    }
}

/// An upload that the client has aborted because it exceeded the limit.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub struct Excess {
    /// Number of bytes received.
    pub received: usize,
    /// The number of bytes that the server announced, if it did.
    pub announced: Option<u32>,
    /// The exceeded limit.
    pub bound: Bound,
}

impl Excess {
    /// The least possible length of the value.
    pub fn least(&self) -> usize {
        match self.bound {
            Bound::Bytes(most) => most,
            Bound::Time(_) => self.received,
        }
    }
}

/// The limit of an [`UploadLimit`] that an upload has exceeded.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Bound {
    Bytes(usize),
    Time(Duration),
}

/// `upload ended after 65541 of 4294967295 bytes: expected at most 65536 bytes`.
impl fmt::Display for Excess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "upload ended after {}", self.received)?;
        self.announced.map_or(Ok(()), |announced| write!(f, " of {announced}"))?;
        match self.bound {
            Bound::Bytes(most) => write!(f, " bytes: expected at most {most} bytes"),
            Bound::Time(most) => write!(f, " bytes: expected its end within {most}"),
        }
    }
}
