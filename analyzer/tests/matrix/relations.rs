//! Relations between diagnoses, which hold whatever the rules are: a capture that is renumbered, shifted, split,
//! converted, or recorded beside another bus has the same findings.

use super::cell::Cell;
use super::draw::Draw;
use super::judge;
use super::measure::healthy;
use super::play::{EPOCH, play};
use canvass_analyzer::NodeId;
use canvass_analyzer::dictionary::KnownDevice;
use canvass_analyzer::findings::{Finding, Results};
use canvass_traces::{
    CanId, Capture, ChannelId, Channels, Format, Frame, Loss, Merge, Naming, ReadOptions, Record, Source, Timestamp,
    WriteOptions,
};
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// A capture with the descriptions that belong to it.
struct Given {
    name: String,
    records: Vec<Record>,
    descriptions: Vec<(NodeId, KnownDevice)>,
}

/// A record as a line of candump's log.
pub fn line(record: &Record) -> String {
    let nanos = record.timestamp.nanos();
    let (seconds, micros) = (nanos / 1_000_000_000, nanos / 1000 % 1_000_000);
    format!("({seconds}.{micros:06}) can{} {}\n", record.channel.0, record.frame)
}

/// What a finding says. Times count from the first record.
fn says(finding: &Finding, origin: u64, node: impl Fn(u8) -> u8) -> String {
    let number = |id: Option<NodeId>| id.map(|id| node(id.raw()));
    let (first, last) = (finding.first.nanos().wrapping_sub(origin), finding.last.nanos().wrapping_sub(origin));
    let channel = finding.channel.map(|channel| channel.0);
    let (node, from, object) = (number(finding.node), number(finding.origin), finding.object);
    let (rule, severity, count) = (finding.rule.id, finding.severity, finding.count);
    format!("{rule} {severity:?} {channel:?} {node:?} {from:?} {object:?} x{count} {first}..{last}")
}

/// What a diagnosis says, in the order of its stories.
fn told(results: &Results, origin: u64, node: impl Fn(u8) -> u8 + Copy) -> Vec<String> {
    let of_story = |story: &canvass_analyzer::findings::Story| {
        let consequences = story.consequences.iter().flat_map(|consequence| &consequence.findings);
        story.head.iter().chain(consequences).copied().collect::<Vec<_>>()
    };
    let order = results.stories.iter().flat_map(of_story);
    order.map(|at| says(&results.findings[at], origin, node)).collect()
}

impl Given {
    fn diagnosed(&self, records: &[Record]) -> Results {
        judge::diagnose(records, &self.descriptions)
    }

    fn origin(records: &[Record]) -> u64 {
        records.first().map_or(0, |record| record.timestamp.nanos())
    }

    /// What the diagnosis of other records says.
    fn told(&self, records: &[Record]) -> Vec<String> {
        told(&self.diagnosed(records), Self::origin(records), |node| node)
    }

    fn same(&self, relation: &str, records: &[Record]) {
        assert_eq!(self.told(records), self.told(&self.records), "{}: {relation}", self.name);
    }
}

/// Files of captures in a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> =
        entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| path.is_file()).collect();
    files.sort();
    files
}

/// The records of a capture, with its channels numbered by their first records.
fn records_of(captures: Vec<Capture>) -> Vec<Record> {
    let merge = Merge::new(captures, Naming::SameBus);
    let mut numbers = HashMap::new();
    let mut records = Vec::new();
    for (_, item) in merge {
        let Ok(mut record) = item else { continue };
        let next = numbers.len() as u16;
        record.channel = ChannelId(*numbers.entry(record.channel).or_insert(next));
        record.place = canvass_traces::Place::default();
        records.push(record);
    }
    records
}

/// The samples of the project, and the captures in the folder that `CANVASS_MATRIX_CAPTURES` names.
fn captures() -> Vec<Given> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut paths = files(&root.join("traces/samples"));
    paths.extend(files(&root.join("docs/examples")));
    if let Some(more) = std::env::var_os("CANVASS_MATRIX_CAPTURES") {
        paths.extend(files(Path::new(&more)));
    }
    let given = |path: &PathBuf| {
        let capture = Capture::open(path, &ReadOptions::default()).ok()?;
        let records = records_of(vec![capture]);
        Some(Given { name: path.display().to_string(), records, descriptions: Vec::new() })
    };
    paths.iter().filter_map(given).filter(|given| !given.records.is_empty()).collect()
}

/// Cells of the matrix, drawn.
fn incidents(count: usize) -> Vec<Given> {
    let seed = 1;
    let mut cells = Cell::all();
    Draw::new(seed, "relations").shuffle(&mut cells);
    let given = |cell: &Cell| {
        let (network, records, _) = cell.records(seed)?;
        Some(Given { name: format!("{cell}@{seed}"), records, descriptions: network.descriptions() })
    };
    cells.iter().filter_map(given).take(count).collect()
}

/// A sink whose bytes can be read afterwards.
#[derive(Clone, Default)]
struct Sink(Arc<Mutex<Vec<u8>>>);

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().expect("no other thread writes").extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Writes the records as a file of this format. Returns `None` if the format loses their times or channels.
fn written(records: &[Record], format: Format) -> Option<Vec<u8>> {
    let mut channels = Channels::new();
    let highest = records.iter().map(|record| record.channel.0).max()?;
    (0..=highest).for_each(|number| {
        channels.intern(&format!("can{number}"));
    });
    let sink = Sink::default();
    let options = WriteOptions { time_base: canvass_traces::TimeBase::Utc, ..WriteOptions::default() };
    let mut writer = format.create(Box::new(sink.clone()), &options).ok()?;
    for record in records {
        writer.write(record, &channels).ok()?;
    }
    writer.finish().ok()?;
    let is_kept = |loss: Loss| {
        loss == Loss::ChannelName && highest == 0
            || matches!(loss, Loss::Direction | Loss::Date | Loss::UnknownDate | Loss::TimeZone | Loss::Comment)
    };
    let is_whole = writer.losses().iter().all(|(loss, _)| is_kept(loss));
    drop(writer);
    let bytes = sink.0.lock().expect("no other thread writes").clone();
    is_whole.then_some(bytes)
}

fn reopened(parts: &[Vec<u8>]) -> Vec<Record> {
    let open = |bytes: &Vec<u8>| {
        Capture::from_source("part", Source::from_bytes(bytes.clone()), &ReadOptions::default())
            .expect("it was just written")
    };
    records_of(parts.iter().map(open).collect())
}

fn hold_for(given: &Given) {
    let shifted = |by: u64| {
        given.records.iter().map(move |record| {
            let mut record = record.clone();
            record.timestamp = Timestamp(record.timestamp.nanos().saturating_add(by));
            record
        })
    };
    given.same("shifted by a day and a bit", &shifted(86_400_123_456_000).collect::<Vec<_>>());
    let middle = given.records.len() / 2;
    let parts = [&given.records[..middle], &given.records[middle..]].map(|part| written(part, Format::Pcapng));
    if let [Some(one), Some(other)] = parts {
        given.same("split in two", &reopened(&[one, other]));
    }
    for format in Format::all().filter(|format| format.is_written()) {
        if let Some(bytes) = written(&given.records, format) {
            given.same(format.id(), &reopened(&[bytes]));
        }
    }
    // A description is of a node on every bus.
    if given.descriptions.is_empty() {
        beside_another_bus(given);
    }
}

/// A healthy bus on another channel changes nothing, and has no findings itself.
fn beside_another_bus(given: &Given) {
    let own = given.records.iter().map(|record| record.channel.0 + 1).max().unwrap_or(0);
    let start = Given::origin(&given.records);
    let other = healthy(3, 1);
    let other = play(&other.plan, &HashMap::new()).into_iter().map(|mut record| {
        record.timestamp = Timestamp(start + (record.timestamp.nanos() - EPOCH));
        record.channel = ChannelId(own);
        record
    });
    let mut records: Vec<Record> = given.records.iter().cloned().chain(other).collect();
    records.sort_by_key(|record| record.timestamp);
    let results = given.diagnosed(&records);
    let told_beside = told(&results, start, |node| node);
    let channel = format!("Some({own})");
    let is_other = |says: &String| says.split(' ').nth(2) == Some(&channel);
    let expected = given.told(&given.records);
    assert!(!told_beside.iter().any(is_other), "{}: {told_beside:#?}", given.name);
    let mut sorted = [told_beside, expected];
    // The order of stories may depend on how many buses there are, what they tell may not.
    sorted.iter_mut().for_each(|told| told.sort());
    assert_eq!(sorted[0], sorted[1], "{}: beside another bus", given.name);
}

#[test]
fn captures_keep_their_findings() {
    let captures = captures();
    assert!(captures.len() > 20, "{} captures", captures.len());
    captures.iter().filter(|given| is_in_order(&given.records)).for_each(hold_for);
}

fn is_in_order(records: &[Record]) -> bool {
    records.windows(2).all(|pair| pair[0].timestamp <= pair[1].timestamp)
}

#[test]
fn incidents_keep_their_findings() {
    incidents(12).iter().for_each(hold_for);
}

/// How far nodes are renumbered.
const RENUMBERED_BY: u8 = 20;

/// The frame with other node-IDs, in the predefined connection set.
fn renumbered(frame: &Frame) -> Frame {
    let Some(id) = frame.id().as_standard().filter(|_| !frame.is_error()) else { return *frame };
    let node = id & 0x7F;
    let is_of_node = node != 0 && (id < 0x100 && id > 0x080 || (0x181..0x780).contains(&id));
    let by = if is_of_node { u16::from(RENUMBERED_BY) } else { 0 };
    let id = CanId::standard_masked(u32::from(id + by));
    let mut data = frame.data().to_vec();
    // An NMT command names a node in its second byte.
    if id.raw() == 0 && data.get(1).is_some_and(|node| (1..=107).contains(node)) {
        data[1] += RENUMBERED_BY;
    }
    let other = if frame.is_remote() { Frame::remote(id, frame.len() as u8) } else { Frame::new(id, &data) };
    other.unwrap_or(*frame)
}

#[test]
fn renumbered_nodes_keep_their_findings() {
    let seed = 2;
    let mut cells = Cell::all();
    Draw::new(seed, "renumbered").shuffle(&mut cells);
    // Where payloads hold identifiers and node-IDs, frames alone are not enough to renumber.
    let is_plain = |cell: &&Cell| {
        let id = cell.to_string();
        let is_base = ["master-driven/unknown", "event-driven/unknown", "polled/unknown", "running/unknown"];
        is_base.iter().any(|base| id.starts_with(base)) && !id.contains("node-id")
    };
    let drawn = cells.iter().filter(is_plain).filter_map(|cell| Some((cell, cell.records(seed)?.1)));
    for (cell, records) in drawn.filter(|(_, records)| !has_mpdo(records)).take(12) {
        let other: Vec<Record> = records
            .iter()
            .map(|record| Record::new(record.timestamp, record.channel, renumbered(&record.frame)))
            .collect();
        let origin = Given::origin(&records);
        let before = told(&judge::diagnose(&records, &[]), origin, |node| node + RENUMBERED_BY);
        let after = told(&judge::diagnose(&other, &[]), origin, |node| node);
        assert_eq!(before, after, "{cell}@{seed}");
    }
}

/// Whether there is a multiplexed PDO, which has a node-ID in its first byte.
fn has_mpdo(records: &[Record]) -> bool {
    records.iter().any(|record| matches!(record.frame.id().raw(), 0x381..0x400) && record.frame.len() == 8)
}

/// No finding accuses a node of a healthy network, even if the capture lacks the first frames.
#[test]
fn a_healthy_capture_without_its_beginning_accuses_nobody() {
    for number in 0..14 {
        let network = healthy(5, number);
        let records = play(&network.plan, &HashMap::new());
        let begin = Draw::new(5, &format!("cut/{number}")).below(records.len() as u64 * 3 / 4) as usize;
        let results = judge::diagnose(&records[begin..], &network.descriptions());
        let accused =
            results.findings.iter().filter(|finding| finding.severity != canvass_analyzer::findings::Severity::Info);
        let accused: Vec<String> = accused.map(|finding| judge::show(0, finding)).collect();
        assert!(accused.is_empty(), "healthy/{number}@5 from record {begin}: {accused:#?}");
    }
}
