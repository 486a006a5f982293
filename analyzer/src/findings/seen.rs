//! Kept frames, and frames as evidence.

use crate::network::Decoded;
use canvass_traces::{Record, Timestamp};

/// An earlier frame, kept as evidence.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The frame.
    pub record: Record,
    /// The frame as it was decoded at its time.
    pub decoded: Decoded,
}

/// A frame that proves a finding.
#[derive(Clone, Copy)]
pub struct Evidence<'a> {
    /// The frame.
    pub record: &'a Record,
    /// The frame as it was decoded at its time.
    pub decoded: &'a Decoded,
}

impl Seen {
    /// Time of the frame.
    pub const fn time(&self) -> Timestamp {
        self.record.timestamp
    }

    /// The frame as evidence.
    pub const fn evidence(&self) -> Evidence<'_> {
        Evidence { record: &self.record, decoded: &self.decoded }
    }
}
