//! Statistics of one bus.

use super::bit_rate::BitRate;
use super::load::Load;
use super::node::NodeStatistics;
use super::peak::Peak;
use super::test_run::TestRun;
use crate::message::{Message, Service};
use crate::network::{Bus, Cause, Decoded};
use crate::room::Room;
use crate::wire::error_control::State;
use crate::{NodeId, PerNode};
use canvass_traces::{Duration, Record, Timestamp};

/// Collects the statistics of one bus.
pub struct Statistics {
    frames: [u64; Service::ALL.len()],
    bits: [u64; Service::ALL.len()],
    first: Option<Timestamp>,
    last: Timestamp,
    load: Load,
    bit_rate: BitRate,
    nodes: PerNode<Option<Box<NodeStatistics>>>,
    test_run: TestRun,
    /// The begin of the current window of all peaks.
    window: Timestamp,
    peak: Peak,
    peaks: [Peak; Service::ALL.len()],
    copies: u64,
    /// Number of frames whose times are no multiples of 10 µs. Without such frames, the clock is too coarse for a bit
    /// rate.
    fine: u64,
    /// Memory for the lists of nodes.
    room: Room,
}

/// The statistics of one bus.
#[derive(Clone, Debug)]
pub struct BusStatistics {
    /// Number of frames by service, in the order of [`Service::ALL`].
    pub frames: [u64; Service::ALL.len()],
    /// Number of bits by service, with stuff bits and intermission.
    pub bits: [u64; Service::ALL.len()],
    /// Time of the first frame.
    pub first: Timestamp,
    /// Time of the last frame.
    pub last: Timestamp,
    /// The bit rate in bit/s, given or inferred.
    pub bit_rate: Option<u32>,
    /// Whether the bit rate was inferred.
    pub is_inferred: bool,
    /// Bits over time.
    pub load: Load,
    /// The fullest window.
    pub peak: Peak,
    /// The fullest window of each service, in the order of [`Service::ALL`].
    pub peaks: [Peak; Service::ALL.len()],
    /// Number of frames that the interface recorded twice; only the number of frames includes them.
    pub copies: u64,
    /// The nodes that sent a frame, or did not answer a request.
    pub nodes: Vec<(NodeId, NodeStatistics)>,
    /// The cases of a conformance test, if there was one.
    pub test_run: TestRun,
}

impl Statistics {
    /// Begins the statistics; lists of nodes take their memory from `room`.
    pub fn new(room: Room) -> Self {
        Self {
            frames: Default::default(),
            bits: Default::default(),
            first: None,
            last: Timestamp::default(),
            load: Load::default(),
            bit_rate: BitRate::default(),
            nodes: PerNode::default(),
            test_run: TestRun::default(),
            window: Timestamp::default(),
            peak: Peak::default(),
            peaks: Default::default(),
            copies: 0,
            fine: 0,
            room,
        }
    }

    /// Counts a frame. `bits` is the length of the frame with the intermission; 0 if unknown.
    pub fn frame(&mut self, record: &Record, bits: u32, decoded: &Decoded, bus: &Bus) {
        let now = record.timestamp;
        if now.since(self.window) >= Peak::WINDOW || now < self.window {
            self.end_window();
            self.window = Peak::begin(now);
        }
        self.frames[decoded.service as usize] += 1;
        self.bits[decoded.service as usize] += u64::from(bits);
        self.first.get_or_insert(now);
        self.last = self.last.max(now);
        self.fine += u64::from(!now.nanos().is_multiple_of(10_000));
        if bits > 0 {
            self.load.add(now, bits);
            self.bit_rate.frame(now, bits);
        }
        if let Some(comment) = record.comment() {
            self.test_run.comment(now, record.place, comment, &self.room);
        }
        match decoded.message {
            Message::CaseMarker(marker) => self.test_run.marker(now, record.place, marker, &self.room),
            _ => self.test_run.frame(now, record.place),
        }
        if matches!(decoded.message, Message::Nmt(nmt) if nmt.node == 0) {
            self.commanded(now, bus);
        }
        if let Some(node) = decoded.node {
            self.nodes[node].get_or_insert_default().frame(now, bits, decoded, bus, &self.room);
        }
    }

    /// Ends the window: the bits counted since its begin belong to it.
    #[cold]
    fn end_window(&mut self) {
        self.peak.end(self.window, self.bits.iter().sum());
        for (peak, bits) in self.peaks.iter_mut().zip(self.bits) {
            peak.end(self.window, bits);
        }
        for node in self.nodes.values_mut().flatten() {
            node.peak.end(self.window, node.bits);
        }
    }

    /// Counts a copy of the latest frame with the same CAN-ID.
    pub const fn copy(&mut self, of: &Decoded) {
        self.frames[of.service as usize] += 1;
        self.copies += 1;
    }

    /// The number of copies.
    pub const fn copies(&self) -> u64 {
        self.copies
    }

    /// The inferred bit rate in bit/s, if the frames show it.
    pub(crate) fn inferred_bit_rate(&self) -> Option<u32> {
        let slack = if self.fine > 0 { Duration::from_micros(2) } else { Duration::from_millis(1) };
        let fullest = self.peak.with(self.window, self.bits.iter().sum()).map_or(0, |best| best.1);
        self.bit_rate.inferred(slack, fullest)
    }

    /// Notes the states of existing nodes after a command to all nodes.
    fn commanded(&mut self, now: Timestamp, bus: &Bus) {
        for id in NodeId::all() {
            let Some((state, Cause::Command)) = bus.node(id).and_then(|node| node.state) else { continue };
            if let Some(node) = &mut self.nodes[id] {
                let known = node.states.last().map(|change| change.state);
                if known != Some(state) || state == State::BOOT_UP {
                    node.state(now, state, Cause::Command, &self.room);
                }
            }
        }
    }

    /// The statistics, with the given bit rate or else the inferred one.
    pub fn finish(mut self, now: Timestamp, bit_rate: Option<u32>) -> BusStatistics {
        self.end_window();
        let first = self.first.unwrap_or(now);
        let inferred = if bit_rate.is_none() { self.inferred_bit_rate() } else { None };
        BusStatistics {
            frames: self.frames,
            bits: self.bits,
            first,
            last: self.last,
            bit_rate: bit_rate.or(inferred),
            is_inferred: inferred.is_some(),
            load: self.load,
            peak: self.peak,
            peaks: self.peaks,
            copies: self.copies,
            nodes: self.nodes.into_all().filter_map(|(id, node)| Some((id, node?.shown()?))).collect(),
            test_run: self.test_run,
        }
    }
}

impl BusStatistics {
    /// Time from the first to the last frame.
    pub fn duration(&self) -> Duration {
        self.last.since(self.first)
    }

    /// Number of all frames.
    pub fn total(&self) -> u64 {
        self.frames.iter().sum()
    }

    /// The bit rate in words, and whether it is inferred: `500 kbit/s (inferred)`.
    pub fn bit_rate_text(&self) -> Option<String> {
        let inferred = if self.is_inferred { " (inferred)" } else { "" };
        self.bit_rate.map(|rate| format!("{} kbit/s{inferred}", f64::from(rate) / 1000.0))
    }

    /// The mean load in percent, if the bit rate is known.
    pub fn mean_load(&self) -> Option<f64> {
        self.share_of_load(self.bits.iter().sum())
    }

    /// The load of the fullest tenth of a second in percent and its time, if the bit rate is known.
    pub fn peak_load(&self) -> Option<(Timestamp, f64)> {
        self.peak.percent(self.bit_rate?)
    }

    /// The mean load of this number of bits in percent, if the bit rate is known.
    pub fn share_of_load(&self, bits: u64) -> Option<f64> {
        let bit_rate = self.bit_rate.filter(|_| self.duration() > Duration::ZERO)?;
        Some(Load::percent(bits, self.duration(), bit_rate))
    }

    /// The average rate of this number of frames per second; `None` for a capture without duration.
    pub fn rate(&self, frames: u64) -> Option<f64> {
        let seconds = self.duration().nanos() as f64 / 1e9;
        (seconds > 0.0).then(|| frames as f64 / seconds)
    }
}
