//! Shows a capture to every rule, record by record.

use super::capture::{self, OutOfOrder};
use super::finding::Finding;
use super::order::Disorder;
use super::provoked;
use super::sink::{Findings, Reported, Sink};
use super::source::SourceQuality;
use super::stories::{self, Story};
use super::thresholds::Thresholds;
use super::watch::{BusWatch, Incoming};
use crate::NodeId;
use crate::dictionary::KnownDevice;
use crate::network::{Bus, Candidates, Decoded, Network};
use crate::room::Room;
use crate::statistics::BusStatistics;
use canvass_traces::{ChannelId, Duration, Record};
use std::sync::Arc;

/// Diagnoses a capture. Memory does not grow with the length of the capture.
///
/// ```
/// use canvass_analyzer::findings::{Diagnosis, Thresholds};
/// use canvass_traces::{Capture, ReadOptions, Reader, Source};
///
/// // Node 5 is operational, and boots up again without a command.
/// let log = "(1.000000) can0 705#00\n(1.100000) can0 000#0105\n(1.200000) can0 705#05\n(2.200000) can0 705#05\n\
///            (2.700000) can0 705#00\n";
/// let mut capture = Capture::from_source("a.log", Source::from_bytes(log), &ReadOptions::default())?;
/// let mut diagnosis = Diagnosis::new(Thresholds::default());
/// while let Some(item) = capture.next() {
///     diagnosis.record(&item.expect("nothing is damaged"));
/// }
/// let results = diagnosis.finish(&[]);
/// let found: Vec<_> = results.findings.iter().map(|finding| finding.rule.id).collect();
/// assert_eq!(found, ["nodes/boot-up-without-command"]);
/// # Ok::<(), canvass_traces::OpenError>(())
/// ```
pub struct Diagnosis {
    network: Network,
    thresholds: Thresholds,
    bit_rates: BitRates,
    room: Room,
    buses: Vec<Option<Box<BusWatch>>>,
    watched: usize,
    findings: Findings,
    /// The last frame, decoded.
    decoded: Option<Decoded>,
    /// Number of frames on channels beyond [`Diagnosis::BUSES`], which no rule saw.
    unwatched: u64,
    disorder: Disorder,
}

/// The given bit rates, in bit/s.
#[derive(Default)]
struct BitRates {
    of_all: Option<u32>,
    of_channels: Vec<(ChannelId, u32)>,
}

impl BitRates {
    fn of(&self, channel: ChannelId) -> Option<u32> {
        let of_channel = || self.of_channels.iter().find(|row| row.0 == channel).map(|row| row.1);
        self.of_all.or_else(of_channel)
    }
}

/// The results of a diagnosis.
#[derive(Debug)]
pub struct Results {
    /// The findings: the worst first, then by time.
    pub findings: Vec<Finding>,
    /// The findings grouped by cause; the group with the worst consequences first.
    pub stories: Vec<Story>,
    /// Rules with more findings than are kept, and the number of reports left out.
    pub omitted: Vec<(&'static str, u64)>,
    /// Number of frames on channels beyond [`Diagnosis::BUSES`], which were not diagnosed.
    pub unwatched: u64,
    /// Number of findings that [`Results::keep_nodes`] has left out.
    pub left_out: usize,
    /// The statistics of each bus, by channel.
    pub buses: Vec<(ChannelId, BusStatistics)>,
}

/// A frame after the rules have seen it.
pub struct Observed<'a> {
    /// The decoded frame.
    pub decoded: &'a Decoded,
    /// The bus of the frame, after the frame.
    pub bus: &'a Bus,
    /// Findings that this frame made, or made worse.
    pub reported: &'a [Reported],
}

impl Diagnosis {
    /// Maximum number of channels that are watched.
    pub const BUSES: usize = 64;
    /// Limit of the statistics of all nodes in bytes, as a node may have any number of states, errors, EMCY codes and
    /// response times: enough for several buses with all nodes.
    const ROOM: usize = 8 << 20;
    /// Least interval between two calls of the rules' clocks.
    pub const TICK: Duration = Duration::from_millis(20);

    /// Begins a diagnosis with these thresholds.
    pub fn new(thresholds: Thresholds) -> Self {
        Self {
            network: Network::new(),
            thresholds,
            bit_rates: BitRates::default(),
            room: Room::new(Self::ROOM),
            buses: Vec::new(),
            watched: 0,
            findings: Findings::default(),
            decoded: None,
            unwatched: 0,
            disorder: Disorder::default(),
        }
    }

    /// Sets the device of a node, on all buses.
    pub fn describe(&mut self, node: NodeId, device: impl Into<Arc<KnownDevice>>) {
        self.network.describe(node, device);
    }

    /// Sets the models by which undescribed nodes can be recognised.
    pub fn offer(&mut self, candidates: Candidates) {
        self.network.offer(candidates);
    }

    /// Sets the bit rate of all buses in bit/s; by default the bit rate is inferred.
    pub const fn set_bit_rate(&mut self, bit_rate: u32) {
        self.bit_rates.of_all = Some(bit_rate);
    }

    /// Sets the bit rate of one bus in bit/s, for a capture that names it. Must be called before the first record of
    /// the bus. [`Diagnosis::set_bit_rate`] takes precedence.
    pub fn say_bit_rate(&mut self, channel: ChannelId, bit_rate: u32) {
        self.bit_rates.of_channels.push((channel, bit_rate));
    }

    /// Diagnoses the next record; `None` if its channel is not watched.
    pub fn record(&mut self, record: &Record) -> Option<Observed<'_>> {
        self.findings.reported.clear();
        let Some(watch) =
            watch(&mut self.buses, &mut self.watched, record, &self.thresholds, &self.bit_rates, &self.room)
        else {
            self.unwatched += 1;
            return None;
        };
        watch.advance(record, &self.network, &mut self.findings);
        let incoming = Incoming::new(record);
        if let Some(of) = watch.original(&incoming) {
            watch.copy(&of);
            self.decoded = Some(of);
        } else {
            let decoded = self.decoded.insert(self.network.handle(record));
            watch.frame(&incoming, decoded, &self.network, &mut self.findings);
        }
        let (decoded, bus) = (self.decoded.as_ref()?, self.network.bus(record.channel)?);
        Some(Observed { decoded, bus, reported: &self.findings.reported })
    }

    /// Tells that frames may be missing here: the recorder lost some, or a part of the capture could not be read.
    pub fn interrupted(&mut self) {
        for watch in self.buses.iter_mut().flatten() {
            watch.interrupted();
        }
    }

    /// Tells that the records were reordered, as [`InOrder`](super::InOrder) reports it.
    pub const fn disordered(&mut self, disorder: Disorder) {
        self.disorder = disorder;
    }

    /// Ends the diagnosis.
    pub fn finish(mut self, sources: &[SourceQuality<'_>]) -> Results {
        for watch in self.buses.iter_mut().flatten() {
            watch.finish(&self.network, &mut self.findings);
        }
        let mut sink = Sink { findings: &mut self.findings, rule: OutOfOrder::METADATA, bus: None };
        capture::tell_disorder(&self.disorder, &mut sink);
        capture::check(sources, &self.thresholds, &mut self.findings);
        let (mut findings, omitted) = self.findings.into_sorted();
        let buses = self.buses.into_iter().flatten();
        let buses: Vec<_> = buses.map(|watch| watch.into_statistics()).collect();
        provoked::tie(&mut findings, &buses);
        let stories = stories::tell(&findings);
        Results { findings, stories, omitted, unwatched: self.unwatched, left_out: 0, buses }
    }
}

/// The watch of a record's bus; `None` if there are too many buses.
fn watch<'a>(
    buses: &'a mut Vec<Option<Box<BusWatch>>>,
    watched: &mut usize,
    record: &Record,
    thresholds: &Thresholds,
    bit_rates: &BitRates,
    room: &Room,
) -> Option<&'a mut BusWatch> {
    let index = usize::from(record.channel.0);
    if buses.len() <= index {
        buses.resize_with(index + 1, || None);
    }
    let slot = buses.get_mut(index)?;
    if slot.is_none() {
        if *watched >= Diagnosis::BUSES {
            return None;
        }
        *watched += 1;
        *slot = Some(begin(record, thresholds, bit_rates, room));
    }
    slot.as_deref_mut()
}

/// Begins to watch another bus. A function of its own, because its large stack frame would slow down every frame.
#[cold]
#[inline(never)]
fn begin(record: &Record, thresholds: &Thresholds, bit_rates: &BitRates, room: &Room) -> Box<BusWatch> {
    Box::new(BusWatch::new(record, thresholds, bit_rates.of(record.channel), room.clone()))
}
