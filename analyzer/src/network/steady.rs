//! Frames that change nothing: whoever does not want to see them need not have them decoded.

use super::Decoded;
use super::bus::Bus;
use super::cob_ids::{Source, Use};
use super::node::{Cause, Node};
use crate::message::{Message, Service};
use crate::wire::srdo::Pair;
use canvass_traces::{ChannelId, Frame, FrameKind, Record, SkipSet};

/// Frames like one that was just taken, which change nothing of what is known of the bus and bring nothing about, and are
/// about the same node and service; only their payloads tell something new.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Steady {
    /// All classical data frames with this 11-bit CAN-ID.
    Id(u16),
    /// Those with this CAN-ID and this byte alone.
    Byte(u16, u8),
    /// All classical data frames with 29-bit CAN-IDs.
    Extended,
}

impl Steady {
    /// Those that are like a classical data frame, as far as the CAN-ID tells.
    pub fn like(frame: &Frame) -> Option<Self> {
        let is_extended =
            frame.id().is_extended() && frame.kind() == FrameKind::Data && !frame.is_fd() && !frame.is_xl();
        frame.cob_id().map(Self::Id).or_else(|| is_extended.then_some(Self::Extended))
    }

    /// Skips them.
    pub fn skip(self, channel: ChannelId, set: &mut SkipSet) {
        match self {
            Self::Id(can_id) => set.all(channel, can_id),
            Self::Byte(can_id, byte) => set.byte(channel, can_id, byte),
            Self::Extended => set.extended(channel),
        }
    }
}

impl Bus {
    /// Another number whenever frames that changed nothing before may change something from now on, or may mean something
    /// else.
    #[inline]
    pub const fn turn(&self) -> u64 {
        self.turn + self.cob_ids.changes()
    }

    /// Which frames like the last one change nothing, until [`Bus::turn`] is another number, or a frame with that CAN-ID
    /// comes that is not like it. To be asked when it has been taken.
    ///
    /// All state that depends on a frame alone was made by the last one: the node is there, its PDO's layout is worked out.
    #[inline]
    pub fn steady(&self, record: &Record, decoded: &Decoded) -> Option<Steady> {
        let frame = &record.frame;
        let Some(can_id) = frame.cob_id() else { return Steady::like(frame) };
        let (used, source) = self.cob_ids.get(can_id);
        let is_steady = match used {
            // What a multiplexed PDO is about is in its payload.
            Use::Pdo(..) => matches!(decoded.message, Message::Pdo(_)),
            Use::ErrorControl(node) if source == Source::Predefined => {
                let byte = heartbeat(self.node(node)?, decoded)?;
                return (*frame.data() == [byte]).then_some(Steady::Byte(can_id, byte));
            }
            // Of other sources, what fits and what does not is counted.
            Use::Sync | Use::Time | Use::GlobalFailSafe => source == Source::Predefined,
            // Two of these may turn out to be a pair.
            Use::Unknown => Pair::of(can_id).is_none() && !self.cob_ids.is_doubted(can_id),
            _ => false,
        };
        is_steady.then_some(Steady::Id(can_id))
    }
}

/// The byte of a heartbeat that says once more what is known: that its node beats, and has this state.
fn heartbeat(node: &Node, decoded: &Decoded) -> Option<u8> {
    let Message::ErrorControl(message) = decoded.message else { return None };
    let is_known = node.state == Some((message.state, Cause::ErrorControl)) && node.guarding.beats();
    (decoded.service == Service::Heartbeat && is_known && !message.toggle).then_some(message.state.0)
}

/// Skips frames that change nothing and that nobody wants to see.
#[derive(Default, Debug)]
pub struct Skipping {
    set: SkipSet,
    /// The turn of each bus when its frames were last looked at.
    turns: Vec<u64>,
}

impl Skipping {
    /// What is skipped.
    pub const fn set(&mut self) -> &mut SkipSet {
        &mut self.set
    }

    /// The bus has taken a frame. Those that are like it are skipped from now on, if `is_unwanted` says of them that
    /// nobody wants to see them.
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
