//! The watch of one bus: its facts, its statistics, and every rule.

use super::Diagnosis;
use super::capture::{self, Copies};
use super::context::{Context, Scene};
use super::dispatch::{self, Dispatch, Traits, Watching};
use super::facts::{Facts, StreamEvent};
use super::latest::Latest;
use super::rule::{Also, Rule};
use super::sink::{Findings, Sink};
use super::thresholds::Thresholds;
use crate::network::{Bus, Decoded, Network};
use crate::room::Room;
use crate::statistics::{BusStatistics, Statistics};
use canvass_traces::{ChannelId, Direction, Duration, INTERMISSION, Place, Quality, Record, Timestamp, bit_length};

/// A frame before it is decoded.
pub struct Incoming<'a> {
    pub record: &'a Record,
    /// The CAN-ID, by [`latest_id`].
    id: Option<u16>,
    /// The number of bits, by [`bit_length`].
    bits: Option<u32>,
}

/// Watches one bus.
pub(crate) struct BusWatch {
    rules: Vec<Watching>,
    dispatch: &'static Dispatch,
    known: Known,
    statistics: Statistics,
    /// Time and place of the first copied frame.
    first_copy: Option<(Timestamp, Place)>,
    /// Time of the next attempt to infer the bit rate.
    next_look: Timestamp,
    next_tick: Timestamp,
}

/// The state of a bus besides its network.
struct Known {
    channel: ChannelId,
    facts: Facts,
    latest: Latest,
    quality: Quality,
    said_bit_rate: Option<u32>,
    /// The bit rate: as given, or as far as it could be inferred.
    bit_rate: Option<u32>,
    start: Timestamp,
    now: Timestamp,
}

impl Known {
    /// The state that rules see.
    fn scene<'a>(&'a self, bus: &'a Bus) -> Scene<'a> {
        Scene {
            now: self.now,
            start: self.start,
            bus,
            channel: self.channel,
            facts: &self.facts,
            latest: &self.latest,
            quality: &self.quality,
            bit_rate: self.bit_rate,
            is_inferred: self.said_bit_rate.is_none(),
        }
    }
}

/// The CAN-ID under which [`Latest`] keeps a frame, if it is a classical frame of 11 bits.
fn latest_id(record: &Record) -> Option<u16> {
    let frame = &record.frame;
    let classical = !frame.is_error() && !frame.is_fd() && !frame.is_xl();
    frame.id().as_standard().filter(|_| classical)
}

impl<'a> Incoming<'a> {
    /// A frame, with the values that several steps need.
    pub fn new(record: &'a Record) -> Self {
        Self { record, id: latest_id(record), bits: bit_length(&record.frame) }
    }
}

impl BusWatch {
    /// Begins to watch the bus of its first frame.
    pub fn new(first: &Record, thresholds: &Thresholds, bit_rate: Option<u32>, room: Room) -> Self {
        Self {
            rules: dispatch::rules(thresholds),
            dispatch: Dispatch::get(),
            known: Known {
                channel: first.channel,
                facts: Facts::default(),
                latest: Latest::default(),
                quality: Quality::default(),
                said_bit_rate: bit_rate,
                bit_rate,
                start: first.timestamp,
                now: first.timestamp,
            },
            statistics: Statistics::new(room),
            first_copy: None,
            next_look: first.timestamp,
            next_tick: first.timestamp + Diagnosis::TICK,
        }
    }

    /// Advances the time to the time of the next record.
    pub fn advance(&mut self, record: &Record, network: &Network, findings: &mut Findings) {
        // A smaller step back is disorder, no step of the clock.
        const DISORDER: Duration = Duration::from_millis(1);
        let gaps = self.known.quality.gaps.count;
        self.known.quality.record(record);
        let steps_back = self.known.now.since(record.timestamp) > DISORDER;
        // A pause of a single node is its own, unless it is very long; a pause of several nodes is the recorder's or
        // the bus's.
        const SWITCHED_OFF: Duration = Duration::from_secs(60);
        let switched_off = record.timestamp.since(self.known.now) > SWITCHED_OFF;
        let silent = self.known.quality.gaps.count > gaps && (self.known.facts.present > 1 || switched_off);
        self.known.now = record.timestamp;
        if steps_back || silent {
            self.interrupted();
            self.next_tick = self.known.now + Diagnosis::TICK;
        } else if self.known.now >= self.next_tick {
            self.next_tick = self.known.now + Diagnosis::TICK;
            self.look_at_bit_rate();
            self.each(network, findings, |rule, scene, sink| rule.tick(scene, sink));
        }
    }

    fn look_at_bit_rate(&mut self) {
        if self.known.said_bit_rate.is_none() && self.known.now >= self.next_look {
            self.known.bit_rate = self.statistics.inferred_bit_rate();
            self.next_look = self.known.now + Duration::from_secs(1);
        }
    }

    /// The original of a copied frame. A copy is the same frame sooner than a bus can carry it again, or the frame
    /// looped back by the sending interface.
    pub fn original(&mut self, incoming: &Incoming<'_>) -> Option<Decoded> {
        let Incoming { record, id, bits } = *incoming;
        const GIVEN_BACK: Duration = Duration::from_millis(1);
        let seen = self.known.latest.get(id?)?;
        let apart = record.timestamp.since(seen.time());
        if apart > GIVEN_BACK || seen.record.frame != record.frame || record.timestamp < seen.time() {
            return None;
        }
        // No bus is faster than 1 Mbit/s; both times may be off by a step of the clock.
        let unsure = self.known.quality.resolution.get().map(|unit| unit.times(2));
        let impossible =
            unsure.is_some_and(|unsure| apart + unsure < Duration::from_micros(u64::from(bits.unwrap_or(0))));
        let both = (record.direction, seen.record.direction);
        let given_back = matches!(both, (Direction::Rx, Direction::Tx) | (Direction::Tx, Direction::Rx));
        if !impossible && !given_back {
            return None;
        }
        let decoded = seen.decoded;
        self.first_copy.get_or_insert((record.timestamp, record.place));
        Some(decoded)
    }

    /// Tells that frames may be missing here, or the clock has stepped.
    pub fn interrupted(&mut self) {
        self.known.facts.interrupted(self.known.now);
        for (_, rule) in &mut self.rules {
            rule.interrupted();
        }
    }

    /// Calls every rule with an event other than a frame.
    fn each(
        &mut self,
        network: &Network,
        findings: &mut Findings,
        act: impl Fn(&mut dyn Rule, &Scene<'_>, &mut Sink<'_>),
    ) {
        let Some(bus) = network.bus(self.known.channel) else { return };
        let scene = self.known.scene(bus);
        for (metadata, rule) in &mut self.rules {
            act(rule.as_mut(), &scene, &mut Sink::of(findings, metadata, &scene));
        }
    }

    /// Handles a frame that is no copy.
    pub fn frame(&mut self, incoming: &Incoming<'_>, decoded: &Decoded, network: &Network, findings: &mut Findings) {
        let Incoming { record, id, bits } = *incoming;
        let bits = bits.map_or(0, |bits| bits + INTERMISSION);
        let Some(bus) = network.bus(self.known.channel) else { return };
        if decoded.repeats_boot_up() {
            self.statistics.frame(record, bits, decoded, bus);
            return;
        }
        let reconfigured = self.known.facts.follow(record, decoded, bus);
        let scene = self.known.scene(bus);
        if let Some(node) = reconfigured {
            self.rules.iter_mut().for_each(|(_, rule)| rule.reconfigured(node, &scene));
        }
        let previous = id.and_then(|id| self.known.latest.get(id));
        let context = Context { scene: &scene, record, bits, decoded, previous };
        let news = &self.known.facts.news;
        let resets = decoded.node.is_some_and(|node| self.known.facts.node(node).pending_reset.is_some());
        let traits = Traits::default()
            .with(Also::ProfileValues, !news.operands.is_empty())
            .with(Also::KnownTpdos, news.is_known_tpdo)
            .with(Also::Resetting, resets)
            .with(Also::Returning, news.returned.is_some())
            .with(Also::EndedTransfers, decoded.ends_transfer())
            .with(Also::UnusualRequests, news.request.is_unusual())
            .with(Also::UnusualPdos, news.stream != StreamEvent::Usual);
        let mut sink = Sink { findings, rule: Copies::METADATA, bus: Some((bus, self.known.channel)) };
        for &at in self.dispatch.places(decoded.service, traits) {
            if let Some((metadata, rule)) = self.rules.get_mut(usize::from(at)) {
                sink.rule = metadata;
                rule.frame(&context, &mut sink);
            }
        }
        self.statistics.frame(record, bits, decoded, bus);
        self.known.facts.note(record, decoded, bus);
        if let Some(id) = id {
            self.known.latest.keep(id, record, decoded);
        }
    }

    /// Counts a copy of a frame.
    pub const fn copy(&mut self, of: &Decoded) {
        self.statistics.copy(of);
    }

    /// The channel and its statistics.
    pub(crate) fn into_statistics(self) -> (ChannelId, BusStatistics) {
        (self.known.channel, self.statistics.finish(self.known.now, self.known.said_bit_rate))
    }

    /// Tells all rules that the capture has ended.
    pub fn finish(&mut self, network: &Network, findings: &mut Findings) {
        if self.known.said_bit_rate.is_none() {
            self.known.bit_rate = self.statistics.inferred_bit_rate();
        }
        self.each(network, findings, |rule, scene, sink| {
            rule.tick(scene, sink);
            rule.finish(scene, sink);
        });
        if let (Some(bus), Some((time, place))) = (network.bus(self.known.channel), self.first_copy) {
            let bus = Some((bus, self.known.channel));
            let mut sink = Sink { findings, rule: Copies::METADATA, bus };
            capture::tell_copies(self.statistics.copies(), time, place, &mut sink);
        }
    }
}
