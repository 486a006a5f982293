//! The data that the page's scripts draw, in few characters even for a page with a million frames.

use super::MOST_FINDINGS;
use super::collector::Collector;
use super::excerpt::{FrameKey, Shown, key_of};
use super::lane::{self, Silences};
use crate::diagnosis::Diagnosed;
use crate::diagnosis::node_table::{profile, who};
use crate::escape::printable;
use crate::signals::series::Series;
use canvass_analyzer::dictionary::names::ErrorName;
use canvass_analyzer::network::Cause;
use canvass_analyzer::statistics::NodeStatistics;
use canvass_analyzer::{NodeId, Service};
use canvass_traces::{ChannelId, Timestamp, hex};
use serde::Serialize;
use std::collections::{BTreeMap, HashMap};

/// All data. Times are in microseconds since the first frame, and channels are positions in the list of names.
#[derive(Serialize)]
pub struct Data<'a> {
    /// The time from the first to the last frame.
    span: i64,
    channels: Vec<String>,
    services: Vec<&'static str>,
    nodes: Nodes<'a>,
    buses: Vec<Bus>,
    signals: Vec<Signal>,
    findings: Vec<Finding>,
    frames: Vec<Frame>,
    /// All different meanings of frames.
    texts: Vec<String>,
    /// The numbers (from 1) of the findings that a frame proves, by the frame's position in the list.
    proofs: BTreeMap<usize, Vec<usize>>,
}

#[derive(Serialize)]
struct Node {
    channel: usize,
    id: u8,
    name: String,
    first: i64,
    last: i64,
    /// Periods of one NMT state or of silence: begin, end, and the state in words.
    states: Vec<(i64, i64, String)>,
    boot_ups: Vec<i64>,
    /// Number of periods of silence that `states` does not list.
    silent: u64,
    /// EMCY messages by time: the time of the first message, its error code in words, and the number of messages.
    emergencies: Vec<(i64, String, u64)>,
}

#[derive(Serialize)]
struct Bus {
    channel: usize,
    /// The unit of the numbers in the lists: percent of the bit rate, or kbit/s.
    unit: &'static str,
    start: i64,
    width: i64,
    mean: Vec<f64>,
    least: Vec<f64>,
    most: Vec<f64>,
}

#[derive(Serialize)]
struct Signal {
    channel: usize,
    node: u8,
    label: String,
    unit: String,
    /// The times of the values, each as the difference from the previous time.
    t: Vec<i64>,
    v: Vec<f64>,
}

#[derive(Serialize)]
struct Finding {
    severity: &'static str,
    title: &'static str,
    node: Option<u8>,
    channel: Option<usize>,
    t: i64,
    count: u64,
    /// The number (from 1) of the finding from which this finding follows.
    of: Option<usize>,
}

/// A frame: its number among all frames (0: not known), nanoseconds, line or packet, channel, node, service, CAN-ID,
/// data, meaning.
type Frame = (u64, i64, u64, usize, Option<u8>, i8, String, String, usize);

impl<'a> Data<'a> {
    /// The data of a diagnosis, with the frames that are shown.
    pub fn new(
        diagnosed: &'a Diagnosed<'a>,
        collected: &'a Collector,
        frames: &[Shown],
        places: &HashMap<FrameKey, usize>,
    ) -> Self {
        let mut names = Names { diagnosed, ids: Vec::new(), start: diagnosed.start().unwrap_or_default() };
        let mut texts = Texts::default();
        for (channel, _) in &diagnosed.results.buses {
            names.place(*channel);
        }
        Self {
            span: span(diagnosed, &names),
            services: Service::ALL.map(Service::name).to_vec(),
            buses: buses(diagnosed, &mut names),
            signals: signals(collected, &mut names),
            findings: findings(diagnosed, &mut names),
            frames: frames.iter().map(|shown| frame(shown, &mut names, &mut texts)).collect(),
            texts: texts.list,
            proofs: proofs(diagnosed, places),
            channels: names.list(),
            nodes: Nodes { collected, names },
        }
    }
}

/// A list of channel names, which gives each channel its position.
struct Names<'a> {
    diagnosed: &'a Diagnosed<'a>,
    ids: Vec<ChannelId>,
    start: Timestamp,
}

impl Names<'_> {
    fn place(&mut self, channel: ChannelId) -> usize {
        self.ids.iter().position(|known| *known == channel).unwrap_or_else(|| {
            self.ids.push(channel);
            self.ids.len() - 1
        })
    }

    fn list(&self) -> Vec<String> {
        self.ids.iter().map(|id| printable(&self.diagnosed.channel(*id)).into_owned()).collect()
    }

    /// Nanoseconds since the start. The number is negative if the clock stepped back.
    fn nanos(&self, time: Timestamp) -> i64 {
        let nanos = i128::from(time.nanos()) - i128::from(self.start.nanos());
        nanos.clamp(i128::from(i64::MIN), i128::from(i64::MAX)) as i64
    }

    fn micros(&self, time: Timestamp) -> i64 {
        self.nanos(time) / 1_000
    }
}

/// A list of texts, which gives each text its position.
#[derive(Default)]
struct Texts {
    list: Vec<String>,
    known: HashMap<String, usize>,
}

impl Texts {
    fn place(&mut self, text: &str) -> usize {
        if let Some(at) = self.known.get(text) {
            return *at;
        }
        let at = self.list.len();
        self.list.push(printable(text).into_owned());
        self.known.insert(text.to_owned(), at);
        at
    }
}

fn span(diagnosed: &Diagnosed<'_>, names: &Names<'_>) -> i64 {
    diagnosed.results.buses.iter().map(|(_, bus)| names.micros(bus.last)).max().unwrap_or(0)
}

/// The nodes of all channels. Each node is made only when it is written, as a node may have many states.
struct Nodes<'a> {
    collected: &'a Collector,
    names: Names<'a>,
}

impl Serialize for Nodes<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let buses = self.names.diagnosed.results.buses.iter().enumerate();
        serializer.collect_seq(buses.flat_map(|(place, (channel, bus))| {
            let nodes = bus.nodes.iter().filter(|(_, node)| node.total() > 0);
            nodes.map(move |(id, node)| self.node((place, *channel), *id, node))
        }))
    }
}

impl Nodes<'_> {
    fn node(&self, (place, channel): (usize, ChannelId), id: NodeId, node: &NodeStatistics) -> Node {
        let names = &self.names;
        let silences = Silences::of(&names.diagnosed.results.findings, channel, id);
        let spans = lane::spans(node, &silences).into_iter();
        let boot_ups = node.states.iter().filter(|change| change.cause == Cause::BootUp);
        let named = |code| ErrorName { code, profile: profile(node) }.to_string();
        let sent = self.collected.emergencies.get(&(channel, id)).into_iter().flat_map(|buckets| buckets.iter());
        Node {
            channel: place,
            id: id.raw(),
            name: printable(&who(node)).into_owned(),
            first: names.micros(node.first),
            last: names.micros(node.last),
            states: spans.map(|span| (names.micros(span.from), names.micros(span.to), span.state)).collect(),
            boot_ups: boot_ups.map(|change| names.micros(change.time)).collect(),
            silent: silences.left_out,
            emergencies: sent.map(|sent| (names.micros(sent.time), named(sent.code), sent.count)).collect(),
        }
    }
}

fn buses(diagnosed: &Diagnosed<'_>, names: &mut Names<'_>) -> Vec<Bus> {
    let of_bus = |(channel, bus): &(ChannelId, canvass_analyzer::statistics::BusStatistics)| {
        let load = &bus.load;
        let start = load.start()?;
        let finest = canvass_analyzer::statistics::Load::FINEST;
        let (unit, full) = bus.bit_rate.map_or(("kbit/s", 1e5), |rate| ("%", f64::from(rate)));
        let last = load.bins().len().saturating_sub(1);
        let percent = |bits: u64, within: f64| {
            let value = if within > 0.0 { bits as f64 * 100.0 / full / within } else { 0.0 };
            (value * 100.0).round() / 100.0
        };
        // The last bucket ends with the capture.
        let within = |at: usize| {
            let width = load.width().nanos() as f64 / 1e9;
            let rest = bus.last.since(start).nanos() as f64 / 1e9 - last as f64 * width;
            if at == last { rest.clamp(width.min(0.1), width) } else { width }
        };
        let bins = load.bins().iter().enumerate();
        let extremes = load.extremes();
        let tenth = finest.nanos() as f64 / 1e9;
        Some(Bus {
            channel: names.place(*channel),
            unit,
            start: names.micros(start),
            width: (load.width().nanos() / 1_000) as i64,
            mean: bins.map(|(at, &bits)| percent(bits, within(at))).collect(),
            least: extremes.iter().map(|bin| percent(bin.least, tenth)).collect(),
            most: extremes.iter().map(|bin| percent(bin.most, tenth)).collect(),
        })
    };
    diagnosed.results.buses.iter().filter_map(of_bus).collect()
}

fn signals(collected: &Collector, names: &mut Names<'_>) -> Vec<Signal> {
    let columns = collected.sampler.columns().iter().take(Series::MOST).enumerate();
    let signal = |(at, column): (usize, &crate::signals::Column)| {
        let points = collected.series.points(at);
        let mut before = 0;
        let t = points.iter().map(|point| {
            let now = names.micros(point.0);
            now - std::mem::replace(&mut before, now)
        });
        Signal {
            t: t.collect(),
            v: points.iter().map(|point| point.1).collect(),
            channel: names.place(column.channel),
            node: column.node.raw(),
            label: printable(&column.label).into_owned(),
            unit: printable(&column.unit).into_owned(),
        }
    };
    columns.map(signal).filter(|signal| !signal.v.is_empty()).collect()
}

fn findings(diagnosed: &Diagnosed<'_>, names: &mut Names<'_>) -> Vec<Finding> {
    let found = diagnosed.results.findings.iter().take(MOST_FINDINGS);
    let consequences = diagnosed.results.stories.iter().flat_map(|story| &story.consequences);
    let causes: HashMap<usize, usize> =
        consequences.flat_map(|consequence| consequence.findings.iter().map(|at| (*at, consequence.of + 1))).collect();
    let finding = |(at, found): (usize, &canvass_analyzer::findings::Finding)| Finding {
        of: causes.get(&at).copied(),
        severity: found.severity.name(),
        title: found.rule.title,
        node: found.node.map(NodeId::raw),
        channel: found.channel.map(|channel| names.place(channel)),
        t: names.micros(found.first),
        count: found.count,
    };
    found.enumerate().map(finding).collect()
}

fn frame(shown: &Shown, names: &mut Names<'_>, texts: &mut Texts) -> Frame {
    let mut data: String =
        if shown.frame.is_remote() { "remote".to_owned() } else { hex::spaced(shown.data()).to_string() };
    if shown.len > shown.data().len() {
        data.push_str(&format!(" … ({} bytes)", shown.len));
    }
    let service = shown.service.and_then(|service| i8::try_from(service as usize).ok()).unwrap_or(-1);
    let id = if shown.frame.is_error() { "error".to_owned() } else { shown.frame.id().to_string() };
    (
        shown.number,
        names.nanos(shown.time),
        shown.place.number,
        names.place(shown.channel),
        shown.node.map(NodeId::raw),
        service,
        id,
        data,
        texts.place(&shown.text),
    )
}

fn proofs(diagnosed: &Diagnosed<'_>, places: &HashMap<FrameKey, usize>) -> BTreeMap<usize, Vec<usize>> {
    let mut proofs: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (at, finding) in diagnosed.results.findings.iter().take(MOST_FINDINGS).enumerate() {
        for place in finding.evidence.iter().filter_map(|exhibit| places.get(&key_of(exhibit)?)) {
            let of_frame = proofs.entry(*place).or_default();
            if of_frame.last() != Some(&(at + 1)) {
                of_frame.push(at + 1);
            }
        }
    }
    proofs
}
