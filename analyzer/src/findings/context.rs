//! What a rule sees.

use super::facts::Facts;
use super::sink::Evidence;
use crate::NodeId;
use crate::message::Message;
use crate::network::{Bus, Decoded};
use canvass_traces::{ChannelId, Duration, Quality, Record, Timestamp};

/// What is known of a bus at a moment.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The moment: the time of the frame that is being looked at, or of the last one.
    pub now: Timestamp,
    /// The time of the first frame on this bus.
    pub start: Timestamp,
    /// The bus with its nodes and transfers, after the frame.
    pub bus: &'a Bus,
    /// Its channel.
    pub channel: ChannelId,
    /// What its nodes have done, before the frame.
    pub facts: &'a Facts,
    /// How far the times of this bus can be trusted.
    pub quality: &'a Quality,
    /// The bit rate in bit/s, where the user said it.
    pub bit_rate: Option<u32>,
}

/// A frame, understood, and what is known around it.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The bus at this moment.
    pub scene: Scene<'a>,
    /// The frame.
    pub record: &'a Record,
    /// What it means.
    pub decoded: &'a Decoded,
    /// The frame before it with the same CAN-ID, if it has 11 bits.
    pub previous: Option<&'a Seen>,
}

/// A frame that was seen earlier, kept as evidence.
#[derive(Clone, Debug)]
pub struct Seen {
    /// The frame.
    pub record: Record,
    /// What it meant then.
    pub decoded: Decoded,
}

impl Scene<'_> {
    /// How far a measured interval may be off because times are coarse: two steps of the clock.
    pub fn slack(&self) -> Duration {
        self.quality.resolution.get().unwrap_or_default().times(2)
    }
}

impl<'a> Context<'a> {
    /// The time of the frame.
    pub const fn now(&self) -> Timestamp {
        self.scene.now
    }

    /// The node that it is about.
    pub const fn node(&self) -> Option<NodeId> {
        self.decoded.node
    }

    /// What it says.
    pub const fn message(&self) -> &'a Message {
        &self.decoded.message
    }

    /// The frame as evidence.
    pub const fn evidence(&self) -> Evidence<'a> {
        Evidence { record: self.record, decoded: self.decoded }
    }

    /// The frame to keep.
    pub fn seen(&self) -> Seen {
        Seen { record: self.record.clone(), decoded: *self.decoded }
    }
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
