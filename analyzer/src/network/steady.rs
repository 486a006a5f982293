//! Frames without effect. A reader that does not need them can leave them undecoded.

use super::Decoded;
use super::bus::Bus;
use super::cob_ids::{Source, Use};
use super::node::{Cause, Node};
use crate::message::{Message, Service};
use crate::wire::srdo::Pair;
use canvass_traces::{ChannelId, Frame, FrameKind, Record, SkipSet};

/// Frames like the current one, which change no state and cause no event, and concern the same node and service; only
/// their payloads are new.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Steady {
    /// All classical data frames with this 11-bit CAN-ID.
    Id(u16),
    /// Data frames with this CAN-ID whose only byte has this value.
    Byte(u16, u8),
    /// All classical data frames with 29-bit CAN-IDs.
    Extended,
}

impl Steady {
    /// The frames like this classical data frame, as far as the CAN-ID tells.
    pub fn like(frame: &Frame) -> Option<Self> {
        let is_extended =
            frame.id().is_extended() && frame.kind() == FrameKind::Data && !frame.is_fd() && !frame.is_xl();
        frame.cob_id().map(Self::Id).or_else(|| is_extended.then_some(Self::Extended))
    }

    /// Adds the frames to the set of skipped frames.
    pub fn skip(self, channel: ChannelId, set: &mut SkipSet) {
        match self {
            Self::Id(can_id) => set.all(channel, can_id),
            Self::Byte(can_id, byte) => set.byte(channel, can_id, byte),
            Self::Extended => set.extended(channel),
        }
    }
}

impl Bus {
    /// A number that changes whenever frames without effect may get an effect or another meaning.
    #[inline]
    pub const fn turn(&self) -> u64 {
        self.turn + self.cob_ids.changes()
    }

    /// The frames like the last one that have no effect, until [`Bus::turn`] changes or a different frame with the same
    /// CAN-ID comes. Must be called after the frame was handled.
    ///
    /// The last frame has made all state that depends on a frame alone: the node exists, its PDO's layout is computed.
    #[inline]
    pub fn steady(&self, record: &Record, decoded: &Decoded) -> Option<Steady> {
        let frame = &record.frame;
        let Some(can_id) = frame.cob_id() else { return Steady::like(frame) };
        let (used, source) = self.cob_ids.get(can_id);
        let is_steady = match used {
            // The payload of a multiplexed PDO names its object.
            Use::Pdo(..) => matches!(decoded.message, Message::Pdo(_)),
            Use::ErrorControl(node) if source == Source::Predefined => {
                let byte = heartbeat(self.node(node)?, decoded)?;
                return (*frame.data() == [byte]).then_some(Steady::Byte(can_id, byte));
            }
            // For uses from other sources, each frame is counted as fitting or not.
            Use::Sync | Use::Time | Use::GlobalFailSafe => source == Source::Predefined,
            // Two CAN-IDs without known use may turn out to be an SRDO pair.
            Use::Unknown => Pair::of(can_id).is_none() && !self.cob_ids.is_doubted(can_id),
            _ => false,
        };
        is_steady.then_some(Steady::Id(can_id))
    }
}

/// The byte of a heartbeat that only repeats the known state.
fn heartbeat(node: &Node, decoded: &Decoded) -> Option<u8> {
    let Message::ErrorControl(message) = decoded.message else { return None };
    let is_known = node.state == Some((message.state, Cause::ErrorControl)) && node.guarding.beats();
    (decoded.service == Service::Heartbeat && is_known && !message.toggle).then_some(message.state.0)
}

/// Skips frames that have no effect and that the reader does not need.
#[derive(Default, Debug)]
pub struct Skipping {
    set: SkipSet,
    /// The turn of each bus at the last check of its frames.
    turns: Vec<u64>,
}

impl Skipping {
    /// The skipped frames.
    pub const fn set(&mut self) -> &mut SkipSet {
        &mut self.set
    }

    /// Handles a frame after the bus has handled it: frames like it are skipped from now on, if `is_unwanted` says that
    /// the reader does not need them.
    #[inline]
    pub fn taken(&mut self, bus: &Bus, record: &Record, decoded: &Decoded, is_unwanted: impl FnOnce(Steady) -> bool) {
        if self.turns.get(usize::from(record.channel.0)) != Some(&bus.turn()) {
            self.turned(record, bus.turn());
        }
        match bus.steady(record, decoded).filter(|steady| is_unwanted(*steady)) {
            Some(steady) => steady.skip(record.channel, &mut self.set),
            None => {
                if let Some(can_id) = record.frame.id().as_standard() {
                    self.set.none(record.channel, can_id);
                }
            }
        }
    }

    #[cold]
    fn turned(&mut self, record: &Record, turn: u64) {
        self.set.forget(record.channel);
        let at = usize::from(record.channel.0);
        if self.turns.len() <= at {
            self.turns.resize(at + 1, 0);
        }
        if let Some(known) = self.turns.get_mut(at) {
            *known = turn;
        }
    }
}
