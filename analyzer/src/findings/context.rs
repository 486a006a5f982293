//! The data that a rule sees.

use super::facts::{Facts, News, Parameters, Pending};
use super::latest::Latest;
use super::seen::{Evidence, Seen};
use crate::NodeId;
use crate::message::{Message, PdoNumber};
use crate::network::{Bus, Decoded};
use canvass_traces::{ChannelId, Duration, Quality, Record, Timestamp};

/// The state of a bus at one moment.
#[derive(Clone, Copy)]
pub struct Scene<'a> {
    /// The moment: the time of the current frame, or of the last one.
    pub now: Timestamp,
    /// The time of the first frame on this bus.
    pub start: Timestamp,
    /// The bus with its nodes and transfers, after the current frame.
    pub bus: &'a Bus,
    /// The channel of the bus.
    pub channel: ChannelId,
    /// The facts about the nodes of the bus, before the current frame.
    pub facts: &'a Facts,
    /// The last frame of each CAN-ID, before the current frame.
    pub latest: &'a Latest,
    /// The reliability of the times on this bus.
    pub quality: &'a Quality,
    /// The bit rate in bit/s, as the user gave it or as inferred from the frames so far.
    pub bit_rate: Option<u32>,
    /// Whether the bit rate is inferred; it may then still change.
    pub is_inferred: bool,
}

/// A decoded frame, and the state of its bus.
#[derive(Clone, Copy)]
pub struct Context<'a> {
    /// The bus at this moment.
    pub scene: &'a Scene<'a>,
    /// The current frame.
    pub record: &'a Record,
    /// Length of the frame in bits with the intermission; 0 if unknown.
    pub bits: u32,
    /// The decoded frame.
    pub decoded: &'a Decoded,
    /// The previous frame with the same CAN-ID, if the CAN-ID has 11 bits.
    pub previous: Option<&'a Seen>,
}

/// Whether the number of frames with equal times proves that the clock is coarse.
pub fn is_coarse(quality: &Quality) -> bool {
    const ONE_OF: u64 = 20;
    quality.simultaneous.saturating_mul(ONE_OF) > quality.frames.total()
}

impl Scene<'_> {
    /// Error of a measured interval because of coarse times: two steps of the clock. Times that are multiples of a unit
    /// do not prove a coarse clock by themselves; two frames must have the same time.
    pub(crate) fn slack(&self) -> Duration {
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

    /// The longest duration of a classical frame of 8 bytes on this bus; a millisecond if the bit rate is unknown.
    pub(crate) fn longest_frame(&self) -> Duration {
        const BITS: u64 = 135;
        self.bit_rate.map_or(Duration::from_millis(1), |rate| Duration(BITS * 1_000_000_000 / u64::from(rate.max(1))))
    }

    /// Whether the node of a request had not booted when it was asked, and has booted since.
    pub(crate) fn was_asked_too_early(&self, pending: &Pending) -> bool {
        let node = pending.request.decoded.node.filter(|_| pending.early);
        let booted = node.and_then(|node| self.facts.node(node).last_boot_up);
        booted.is_some_and(|boot_up| boot_up >= pending.request.time())
    }

    /// Whether the capture has times at all.
    pub(crate) fn has_times(&self) -> bool {
        self.quality.resolution.get().is_some()
    }
}

impl<'a> Context<'a> {
    /// The time of the frame.
    pub const fn now(&self) -> Timestamp {
        self.scene.now
    }

    /// The node that the frame concerns.
    pub const fn node(&self) -> Option<NodeId> {
        self.decoded.node
    }

    /// Whether an NMT command changes the state of a node, so that periodic messages may begin anew.
    pub(crate) const fn begins_anew(&self) -> bool {
        self.scene.facts.news.begins_anew
    }

    /// The facts about the frame that several rules need.
    pub const fn news(&self) -> &'a News {
        &self.scene.facts.news
    }

    /// The TPDO in the frame, with its known parameters: node and number from 1.
    pub fn tpdo(&self) -> Option<(NodeId, u16, &'a Parameters)> {
        let (Some(node), Message::Pdo(PdoNumber::Transmit(number))) = (self.node(), self.message()) else {
            return None;
        };
        Some((node, *number, self.scene.facts.tpdos.of(node, *number)))
    }

    /// The decoded message.
    pub const fn message(&self) -> &'a Message {
        &self.decoded.message
    }

    /// The frame as evidence.
    pub const fn evidence(&self) -> Evidence<'a> {
        Evidence { record: self.record, decoded: self.decoded }
    }

    /// A copy of the frame to keep.
    pub fn seen(&self) -> Seen {
        Seen { record: self.record.clone(), decoded: *self.decoded }
    }
}
