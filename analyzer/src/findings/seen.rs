//! Frames that are kept, and frames that prove something.

use crate::network::Decoded;
use canvass_traces::{Record, Timestamp};

/// A frame that was seen earlier, kept as evidence.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The frame.
    pub record: Record,
    /// What it meant then.
    pub decoded: Decoded,
}

/// A frame that proves something.
#[derive(Clone, Copy)]
pub struct Evidence<'a> {
    /// The frame.
    pub record: &'a Record,
    /// What it meant when it was seen.
    pub decoded: &'a Decoded,
}

impl Seen {
    /// When it was seen.
    pub const fn time(&self) -> Timestamp {
        self.record.timestamp
    }

    /// The frame as evidence.
    pub const fn evidence(&self) -> Evidence<'_> {
        Evidence { record: &self.record, decoded: &self.decoded }
    }
}
