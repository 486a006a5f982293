//! Figures of one bus.

use super::bit_rate::BitRate;
use super::load::Load;
use super::node::NodeStatistics;
use super::test_run::TestRun;
use crate::NodeId;
use crate::message::{Message, Service};
use crate::network::{Bus, Cause, Decoded};
use crate::wire::error_control::State;
use canvass_traces::{Duration, INTERMISSION, Record, Timestamp, bit_length};

/// Collects the figures of one bus.
#[derive(Default)]
pub struct Statistics {
    frames: [u64; Service::ALL.len()],
    bits: [u64; Service::ALL.len()],
    first: Option<Timestamp>,
    last: Timestamp,
    load: Load,
    bit_rate: BitRate,
    nodes: Vec<Option<Box<NodeStatistics>>>,
    test_run: TestRun,
    /// Frames whose times are no multiples of 10 µs: without them, the clock is too coarse for a bit rate.
    fine: u64,
}

/// The figures of one bus.
#[derive(Clone, Debug)]
pub struct BusStatistics {
    /// The frames by service: in the order of [`Service::ALL`].
    pub frames: [u64; Service::ALL.len()],
    /// The bits of these frames, with stuff bits and intermission.
    pub bits: [u64; Service::ALL.len()],
    /// The first frame.
    pub first: Timestamp,
    /// The last frame.
    pub last: Timestamp,
    /// The bit rate in bit/s, as said or inferred.
    pub bit_rate: Option<u32>,
    /// Bits over time.
    pub load: Load,
    /// The nodes that sent something or were addressed.
    pub nodes: Vec<(NodeId, NodeStatistics)>,
    /// The cases of CiA's conformance test tool, if it was at work.
    pub test_run: TestRun,
}

impl Statistics {
    /// Takes a frame.
    pub fn frame(&mut self, record: &Record, decoded: &Decoded, bus: &Bus) {
        let now = record.timestamp;
        let bits = bit_length(&record.frame).map_or(0, |bits| bits + INTERMISSION);
        self.frames[decoded.service as usize] += 1;
        self.bits[decoded.service as usize] += u64::from(bits);
        self.first.get_or_insert(now);
        self.last = self.last.max(now);
        self.fine += u64::from(!now.nanos().is_multiple_of(10_000));
        if bits > 0 {
            self.load.add(now, bits);
            self.bit_rate.frame(now, bits);
        }
        match decoded.message {
            Message::CaseMarker(marker) => self.test_run.marker(now, record.place, marker),
            Message::Nmt(nmt) if nmt.node == 0 => self.commanded(now, bus),
            _ => self.test_run.frame(now),
        }
        if let Some(node) = decoded.node {
            self.node(node).frame(now, bits, decoded, bus);
        }
    }

    /// A command to all nodes has changed the states of those that are there.
    fn commanded(&mut self, now: Timestamp, bus: &Bus) {
        for id in NodeId::all() {
            let Some((state, Cause::Command)) = bus.node(id).and_then(|node| node.state) else { continue };
            if let Some(Some(node)) = self.nodes.get_mut(usize::from(id.raw())) {
                let known = node.states.last().map(|change| change.state);
                if known != Some(state) || state == State::BOOT_UP {
                    node.state(now, state, Cause::Command);
                }
            }
        }
    }

    fn node(&mut self, id: NodeId) -> &mut NodeStatistics {
        if self.nodes.is_empty() {
            self.nodes.resize_with(128, || None);
        }
        // 128 places for the node-IDs 1 to 127.
        self.nodes[usize::from(id.raw())].get_or_insert_default()
    }

    /// The figures; the bit rate is the one that was said, or inferred.
    pub fn finish(self, now: Timestamp, bit_rate: Option<u32>) -> BusStatistics {
        let first = self.first.unwrap_or(now);
        let slack = if self.fine > 0 { Duration::from_micros(2) } else { Duration::from_millis(1) };
        let nodes = NodeId::all().zip(self.nodes.into_iter().skip(1));
        BusStatistics {
            frames: self.frames,
            bits: self.bits,
            first,
            last: self.last,
            bit_rate: bit_rate.or_else(|| self.bit_rate.inferred(slack)),
            load: self.load,
            nodes: nodes.filter_map(|(id, node)| Some((id, *node?))).collect(),
            test_run: self.test_run,
        }
    }
}

impl BusStatistics {
    /// From the first to the last frame.
    pub fn duration(&self) -> Duration {
        self.last.since(self.first)
    }

    /// All frames.
    pub fn total(&self) -> u64 {
        self.frames.iter().sum()
    }

    /// The mean load in percent, where the bit rate is known.
    pub fn mean_load(&self) -> Option<f64> {
        let bits = self.bits.iter().sum();
        let bit_rate = self.bit_rate.filter(|_| self.duration() > Duration::ZERO)?;
        Some(Load::percent(bits, self.duration(), bit_rate))
    }

    /// The load of the fullest time in percent, and when that was; where the bit rate is known.
    pub fn peak_load(&self) -> Option<(Timestamp, f64)> {
        let (at, bits) = self.load.peak()?;
        Some((at, Load::percent(bits, self.load.width(), self.bit_rate?)))
    }
}
