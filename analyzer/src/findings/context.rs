//! What a rule sees.

use super::facts::{Facts, News, Parameters};
use super::latest::Latest;
use super::seen::{Evidence, Seen};
use crate::NodeId;
use crate::message::{Message, PdoNumber};
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
    /// The last frame of each CAN-ID, before the frame.
    pub latest: &'a Latest,
    /// How far the times of this bus can be trusted.
    pub quality: &'a Quality,
    /// The bit rate in bit/s, where the user said it, or the frames until now have shown it.
    pub bit_rate: Option<u32>,
    /// Whether it is inferred: then it may become another one.
    pub is_inferred: bool,
}

/// A frame, understood, and what is known around it.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The bus at this moment.
    pub scene: &'a Scene<'a>,
    /// The frame.
    pub record: &'a Record,
    /// The bits that it takes on the bus with the intermission; 0 where that is not known.
    pub bits: u32,
    /// What it means.
    pub decoded: &'a Decoded,
    /// The frame before it with the same CAN-ID, if it has 11 bits.
    pub previous: Option<&'a Seen>,
}

/// Whether so many frames have the same time as the one before that the clock must be coarse.
pub fn is_coarse(quality: &Quality) -> bool {
    const ONE_OF: u64 = 20;
    quality.simultaneous.saturating_mul(ONE_OF) > quality.frames.total()
}

impl Scene<'_> {
    /// How far a measured interval may be off because times are coarse: two steps of the clock. That all times are
    /// multiples of something proves nothing, as long as no two frames have the same time.
    pub fn slack(&self) -> Duration {
        if self.quality.simultaneous > 0 && is_coarse(self.quality) {
            self.resolution().times(2)
        } else {
            Duration::ZERO
        }
    }

    /// The largest power of ten that divides all times.
    pub fn resolution(&self) -> Duration {
        self.quality.resolution.get().unwrap_or_default()
    }

    /// How long a classical frame of 8 bytes takes at most on this bus; a millisecond where the bit rate is not known.
    pub fn longest_frame(&self) -> Duration {
        const BITS: u64 = 135;
        self.bit_rate.map_or(Duration::from_millis(1), |rate| Duration(BITS * 1_000_000_000 / u64::from(rate.max(1))))
    }

    /// Whether the capture has times at all.
    pub fn has_times(&self) -> bool {
        self.quality.resolution.get().is_some()
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

    /// Whether an NMT command changes the state of some node, so that what was periodic may begin anew.
    pub const fn begins_anew(&self) -> bool {
        self.scene.facts.news.begins_anew
    }

    /// What the frame means to several rules.
    pub const fn news(&self) -> &'a News {
        &self.scene.facts.news
    }

    /// The TPDO that it is, with what is known of its parameters: its node and its number from 1.
    pub fn tpdo(&self) -> Option<(NodeId, u16, &'a Parameters)> {
        let (Some(node), Message::Pdo(PdoNumber::Transmit(number))) = (self.node(), self.message()) else {
            return None;
        };
        Some((node, *number, self.scene.facts.tpdos.of(node, *number)))
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
