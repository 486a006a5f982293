//! The traffic of others and their bus load: the device under test has to work with the rest of the bus.

use crate::foreign::{ForeignKind, ForeignMessages};
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::nmt::{self, Nmt};
use canvass_analyzer::wire::sdo::Request;
use canvass_traces::{CanId, Duration, Record, bit_length};
use std::collections::{BTreeMap, HashMap};

/// The form of a frame, whoever receives it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub(crate) enum Form {
    /// A remote frame.
    Remote,
    /// Data that writes an object, if the CAN-ID is that of SDO requests.
    SdoWrite,
    /// Other data.
    Data,
    /// An NMT command to another node.
    NmtOfOthers,
}

/// The traffic of others while a case ran.
#[derive(Clone, Debug, Default)]
pub(crate) struct Foreign {
    bits: u64,
    frames: HashMap<(CanId, Form), u64>,
}

/// The bit rate that is assumed if the bit rate of the bus is unknown: the highest, so that the actual load is at least
/// the calculated load.
const HIGHEST_BIT_RATE: u32 = 1_000_000;

/// Maximum number of identifiers that are distinguished.
const IDENTIFIERS: usize = 4_096;

impl Foreign {
    /// Counts a frame of others on the bus of this node.
    pub fn count(&mut self, record: &Record, node: NodeId) {
        self.bits += u64::from(bit_length(&record.frame).unwrap_or(0));
        if self.frames.len() < IDENTIFIERS {
            *self.frames.entry((record.frame.id(), form(record, node))).or_default() += 1;
        }
    }

    /// The foreign messages that concern the device under test: `kind` gives the meaning of a frame for the device.
    pub fn messages(&self, kind: impl Fn(u16, Form) -> Option<ForeignKind>) -> Vec<ForeignMessages> {
        let mut counts: BTreeMap<(ForeignKind, u16), u64> = BTreeMap::new();
        for (&(id, form), count) in &self.frames {
            if let Some(can_id) = id.as_standard().filter(|_| form != Form::NmtOfOthers)
                && let Some(kind) = kind(can_id, form)
            {
                *counts.entry((kind, can_id)).or_default() += count;
            }
        }
        counts.into_iter().map(|((kind, can_id), count)| ForeignMessages { kind, can_id, count }).collect()
    }

    /// The bus load in percent over a time span.
    pub fn load(&self, span: Duration, bit_rate: Option<u32>) -> u64 {
        let possible = u128::from(bit_rate.unwrap_or(HIGHEST_BIT_RATE)) * u128::from(span.0) / 1_000_000_000;
        u64::try_from(u128::from(self.bits) * 100 / possible.max(1)).unwrap_or(u64::MAX)
    }

    /// The most frequent identifier, with its number of frames.
    pub(crate) fn loudest(&self) -> Option<(CanId, u64)> {
        let mut counts: HashMap<CanId, u64> = HashMap::new();
        self.frames.iter().for_each(|((id, _), count)| *counts.entry(*id).or_default() += count);
        counts.into_iter().max_by_key(|&(id, count)| (count, std::cmp::Reverse(id)))
    }
}

fn form(record: &Record, node: NodeId) -> Form {
    if record.frame.is_remote() {
        return Form::Remote;
    }
    if record.frame.cob_id() == Some(nmt::CAN_ID) {
        let is_for = |nmt: Nmt| nmt.node == 0 || nmt.node == node.raw();
        return if Nmt::read(record.data()).is_ok_and(is_for) { Form::Data } else { Form::NmtOfOthers };
    }
    match Request::read(record.data()) {
        Ok(Request::InitiateDownload { .. } | Request::DownloadSegment(_)) => Form::SdoWrite,
        Ok(Request::InitiateBlockDownload { .. } | Request::EndBlockDownload { .. }) => Form::SdoWrite,
        _ => Form::Data,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted;
    use canvass_traces::{ChannelId, Frame, Timestamp};

    fn node() -> NodeId {
        NodeId::new(scripted::NODE).unwrap()
    }

    #[test]
    fn the_load_is_that_of_the_bits() {
        let mut foreign = Foreign::default();
        let frame = Frame::full(CanId::standard_masked(0x123), [0x55; 8]);
        let bits = u64::from(bit_length(&frame).unwrap());
        for _ in 0..1_000 {
            foreign.count(&Record::new(Timestamp::ZERO, ChannelId(0), frame), node());
        }
        assert_eq!(foreign.load(Duration::from_secs(1), Some(125_000)), bits * 1_000 * 100 / 125_000);
        assert_eq!(foreign.loudest(), Some((frame.id(), 1_000)));
    }

    /// An unknown bit rate counts as 1 Mbit/s; a time span of zero causes no division by zero.
    #[test]
    fn the_load_is_never_too_high_where_the_bit_rate_is_not_known() {
        let mut foreign = Foreign::default();
        let frame = Frame::full(CanId::standard_masked(0x123), [0x55; 8]);
        let bits = u64::from(bit_length(&frame).unwrap());
        (0..4_000).for_each(|_| foreign.count(&Record::new(Timestamp::ZERO, ChannelId(0), frame), node()));
        assert_eq!(foreign.load(Duration::from_secs(1), None), bits * 4_000 * 100 / 1_000_000);
        assert_eq!(foreign.load(Duration::from_secs(2), None), bits * 4_000 * 100 / 2_000_000);
        assert_eq!(foreign.load(Duration::ZERO, None), bits * 4_000 * 100);
        assert_eq!(foreign.load(Duration::from_secs(1), Some(2)), bits * 4_000 * 100 / 2);
        assert_eq!(Foreign::default().load(Duration::from_secs(1), None), 0);
    }

    /// Of identifiers with equally many frames the one with the highest priority is named; identifiers beyond 4096 are
    /// not distinguished.
    #[test]
    fn the_loudest_is_named() {
        let record = |id| Record::new(Timestamp::ZERO, ChannelId(0), Frame::full(CanId::extended(id).unwrap(), [0; 8]));
        let mut foreign = Foreign::default();
        assert_eq!(foreign.loudest(), None);
        for id in [3, 2, 1, 2, 1] {
            foreign.count(&record(id), node());
        }
        assert_eq!(foreign.loudest(), Some((CanId::extended(1).unwrap(), 2)));
        (100..10_000).for_each(|id| foreign.count(&record(id), node()));
        assert_eq!(foreign.frames.len(), 4_096);
    }

    /// The bytes distinguish writes from reads, and commands to the device from commands to other nodes.
    #[test]
    fn messages_are_counted_by_their_kind() {
        let mut foreign = Foreign::default();
        for text in [
            "63F#4000100000000000",
            "63F#2317100001000000",
            "63F#8000100000000405",
            "63F#6000000000000000",
            "63F#C617100008000000",
            "000#8100",
            "000#013F",
            "000#8101",
            "000#01",
            "73F#R",
        ] {
            foreign.count(&Record::new(Timestamp::ZERO, ChannelId(0), scripted::frame(text)), node());
        }
        let name = |can_id: u16, form: Form| match (can_id, form) {
            (0x63F, Form::SdoWrite) => Some(ForeignKind::SdoWrite),
            (0x63F, _) => Some(ForeignKind::SdoRead),
            (0, _) => Some(ForeignKind::Nmt),
            (_, form) => (form == Form::Remote).then_some(ForeignKind::Guarding),
        };
        let found = foreign.messages(name).into_iter().map(|messages| (messages.kind, messages.can_id, messages.count));
        let expected = [
            (ForeignKind::SdoRead, 0x63F, 3),
            (ForeignKind::SdoWrite, 0x63F, 2),
            (ForeignKind::Nmt, 0, 2),
            (ForeignKind::Guarding, 0x73F, 1),
        ];
        assert_eq!(found.collect::<Vec<_>>(), expected);
    }
}
