//! Lets every rule look at a capture, once, record by record.

use super::capture::{self, OutOfOrder};
use super::finding::Finding;
use super::order::Disorder;
use super::sink::{Findings, Reported, Sink};
use super::source::SourceQuality;
use super::stories::{self, Story};
use super::thresholds::Thresholds;
use super::watch::{BusWatch, Incoming};
use crate::NodeId;
use crate::dictionary::DeviceDescription;
use crate::network::{Bus, Candidates, Decoded, Network};
use crate::statistics::BusStatistics;
use canvass_traces::{ChannelId, Duration, Record};

/// Finds what is wrong in a capture. Memory does not grow with the capture.
pub struct Diagnosis {
    network: Network,
    thresholds: Thresholds,
    bit_rate: Option<u32>,
    buses: Vec<Option<Box<BusWatch>>>,
    watched: usize,
    findings: Findings,
    /// What the last frame means.
    decoded: Option<Decoded>,
    /// Frames of channels beyond [`Diagnosis::BUSES`], which no rule looked at.
    unwatched: u64,
    disorder: Disorder,
}

/// What has come out.
#[derive(Debug)]
pub struct Results {
    /// The findings: the worst first, then by time.
    pub findings: Vec<Finding>,
    /// What they tell: what has the worst consequences first.
    pub stories: Vec<Story>,
    /// The rules of which there were more findings than are kept, with how many reports were left out.
    pub omitted: Vec<(&'static str, u64)>,
    /// Frames of channels beyond [`Diagnosis::BUSES`], which were not looked at.
    pub unwatched: u64,
    /// What was on each bus, by channel.
    pub buses: Vec<(ChannelId, BusStatistics)>,
}

/// A frame as it was looked at.
pub struct Observed<'a> {
    /// What it means.
    pub decoded: &'a Decoded,
    /// Its bus, after the frame.
    pub bus: &'a Bus,
    /// The findings that are new with it, or were never worse.
    pub reported: &'a [Reported],
}

impl Diagnosis {
    /// How many channels are watched at most.
    pub const BUSES: usize = 64;
    /// How often rules look at the clock, at most.
    pub const TICK: Duration = Duration::from_millis(20);

    /// A diagnosis with those thresholds.
    pub fn new(thresholds: Thresholds) -> Self {
        Self {
            network: Network::new(),
            thresholds,
            bit_rate: None,
            buses: Vec::new(),
            watched: 0,
            findings: Findings::default(),
            decoded: None,
            unwatched: 0,
            disorder: Disorder::default(),
        }
    }

    /// Says which device a node is, on all buses.
    pub fn describe(&mut self, node: NodeId, description: DeviceDescription) {
        self.network.describe(node, description);
    }

    /// Says which models nodes that nobody described can be recognised as.
    pub fn offer(&mut self, candidates: Candidates) {
        self.network.offer(candidates);
    }

    /// Says the bit rate of all buses, in bit/s. Without it, it is inferred.
    pub const fn set_bit_rate(&mut self, bit_rate: u32) {
        self.bit_rate = Some(bit_rate);
    }

    /// Takes the next record, and says what it means and what it has shown; `None` where its channel is not watched.
    pub fn record(&mut self, record: &Record) -> Option<Observed<'_>> {
        self.findings.reported.clear();
        let Some(watch) = watch(&mut self.buses, &mut self.watched, record, &self.thresholds, self.bit_rate) else {
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

    /// Frames may be missing here: the recorder lost some, or something could not be read.
    pub fn interrupted(&mut self) {
        for watch in self.buses.iter_mut().flatten() {
            watch.interrupted();
        }
    }

    /// The records were in another order than they came: [`InOrder`](super::InOrder) tells.
    pub const fn disordered(&mut self, disorder: Disorder) {
        self.disorder = disorder;
    }

    /// The capture has ended.
    pub fn finish(mut self, sources: &[SourceQuality<'_>]) -> Results {
        for watch in self.buses.iter_mut().flatten() {
            watch.finish(&self.network, &mut self.findings);
        }
        let mut sink = Sink { findings: &mut self.findings, rule: OutOfOrder::METADATA, bus: None };
        capture::tell_disorder(&self.disorder, &mut sink);
        capture::check(sources, &self.thresholds, &mut self.findings);
        let (findings, omitted) = self.findings.into_sorted();
        let buses = self.buses.into_iter().flatten();
        let buses = buses.map(|watch| watch.into_statistics(self.bit_rate)).collect();
        let stories = stories::tell(&findings);
        Results { findings, stories, omitted, unwatched: self.unwatched, buses }
    }
}

/// What watches the bus of a record, unless there are too many buses.
fn watch<'a>(
    buses: &'a mut Vec<Option<Box<BusWatch>>>,
    watched: &mut usize,
    record: &Record,
    thresholds: &Thresholds,
    bit_rate: Option<u32>,
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
        *slot = Some(Box::new(BusWatch::new(record, thresholds, bit_rate)));
    }
    slot.as_deref_mut()
}
