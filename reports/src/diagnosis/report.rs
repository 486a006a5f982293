//! The diagnosis as a report: the findings, the figures of each node, and the traffic on the buses.

use super::node_table::{self, rounded};
use super::{Diagnosed, findings, json, suites};
use crate::document::{Block, Column, Depth, Document, Fact, Report, Row, Section, Table, fact};
use crate::page_text::counted;
use canvass_analyzer::findings::Severity;
use canvass_analyzer::statistics::{BusStatistics, TestCase};
use std::io::{self, Write};

/// A diagnosis with the options of its report. [`super::html`] makes the page.
#[derive(Clone, Copy, Debug)]
pub struct DiagnosisReport<'a> {
    pub diagnosed: &'a Diagnosed<'a>,
    /// Whether a terminal shows every finding with all its frames, and every node.
    pub is_verbose: bool,
    /// How the user sees the parts that the text leaves out.
    pub advice: Advice,
    /// In JUnit files a less severe finding passes, and the output contains its text.
    pub fail_on: Option<Severity>,
}

/// Texts that tell the user how to see more. The program provides them, as it knows the names of its options. An empty
/// text is left out.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Advice {
    /// The text after the number of findings that are not shown.
    pub findings: &'static str,
    /// The text after the number of nodes or cases that are not shown.
    pub rows: &'static str,
    /// The text after the note that the bit rate is not known.
    pub bit_rate: &'static str,
}

/// Maximum number of lines of a short text, which fits on a screen or a page of paper.
const LINES: usize = 58;
/// Maximum number of nodes in the table of a short text.
const NODES: usize = 16;

impl Report for DiagnosisReport<'_> {
    fn document(&self, depth: Depth) -> Document {
        let facts = facts(self, depth);
        let about = self.diagnosed.provenance.section(depth, depth > Depth::Screen || self.is_verbose);
        let mut tail = vec![section("nodes", "Nodes", nodes(self, depth))];
        tail.extend(test_runs(self, depth));
        let used = facts.len() + 3 + [&about].into_iter().chain(&tail).map(Section::height).sum::<usize>();
        let mut found = findings::blocks(self, depth, LINES.saturating_sub(used));
        let omitted = self.diagnosed.results.omitted.iter();
        found.extend(omitted.map(|(rule, count)| Block::Note(format!("{rule}: {count} more, which are not shown"))));
        if found.is_empty() && depth > Depth::Screen {
            let of = if self.diagnosed.results.left_out > 0 { " of the chosen nodes" } else { "" };
            found.push(Block::Text(format!("Nothing was found{of}.")));
        }
        Document {
            command: "diagnose",
            kind: "CANopen diagnosis",
            title: "Diagnosis".to_owned(),
            outcome: counts(self.diagnosed),
            facts,
            sections: [section("findings", "Findings", found)].into_iter().chain(tail).collect(),
            about: Some(about),
            suites: suites::of(self.diagnosed, self.fail_on),
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        json::render(self.diagnosed, out)
    }
}

fn section(id: &'static str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id, title: title.to_owned(), blocks }
}

/// The number of findings by severity: `1 error, 2 warnings, 0 hints`.
fn counts(diagnosed: &Diagnosed<'_>) -> String {
    let named = [(Severity::Error, "error"), (Severity::Warning, "warning"), (Severity::Info, "hint")];
    let counts = named.map(|(severity, name)| counted(diagnosed.count(severity), name));
    counts.join(", ")
}

/// The facts of the captures and of each bus.
fn facts(report: &DiagnosisReport<'_>, depth: Depth) -> Vec<Fact> {
    let diagnosed = report.diagnosed;
    let advice = if depth == Depth::Screen { report.advice } else { Advice::default() };
    let captures = diagnosed.captures.iter().filter(|_| depth > Depth::Screen);
    let captures = captures.map(|capture| fact("capture", &format!("{} ({})", capture.name, capture.format)));
    let buses = diagnosed.results.buses.iter();
    let buses = buses.map(|(id, bus)| (diagnosed.channel(*id), of_bus(bus, advice)));
    let unwatched = (diagnosed.results.unwatched > 0).then(|| {
        fact("others", &format!("{} frames of further channels were not looked at", diagnosed.results.unwatched))
    });
    let left_out = left_out(diagnosed).map(|text| fact("left out", &text));
    captures.chain(buses).chain(unwatched).chain(left_out).collect()
}

/// The number of findings that only concern nodes that were not chosen.
pub fn left_out(diagnosed: &Diagnosed<'_>) -> Option<String> {
    let count = diagnosed.results.left_out;
    (count > 0).then(|| format!("{} of other nodes", counted(count, "finding")))
}

/// The facts of a bus: `12000 frames in 30 s, 4 nodes (1, 3, 4, 6), 500 kbit/s (inferred), load 4.0 % (peak 7.0 %)`.
fn of_bus(bus: &BusStatistics, advice: Advice) -> String {
    let present: Vec<String> =
        bus.nodes.iter().filter(|(_, node)| node.present).map(|(id, _)| id.to_string()).collect();
    let nodes = match present.len() {
        0 => "no node sent anything".to_owned(),
        count => format!("{} ({})", counted(count, "node"), present.join(", ")),
    };
    let rate = bus.bit_rate_text().unwrap_or_else(|| format!("bit rate not known{}", advice.bit_rate));
    let load = match (bus.mean_load(), bus.peak_load()) {
        (Some(mean), Some((_, peak))) => format!(", load {mean:.1} % (peak {peak:.1} %)"),
        _ => String::new(),
    };
    format!("{} frames in {}, {nodes}, {rate}{load}", bus.total(), rounded(bus.duration()))
}

/// The table of nodes. After a scan many nodes never sent a frame: a short text names these in one line.
fn nodes(report: &DiagnosisReport<'_>, depth: Depth) -> Vec<Block> {
    const SILENT: usize = 3;
    let is_short = depth == Depth::Screen && !report.is_verbose;
    let silent = node_table::silent(report.diagnosed);
    let are_rows = !is_short || silent.iter().map(|(_, nodes)| nodes.len()).sum::<usize>() <= SILENT;
    let mut rows = node_table::rows(report.diagnosed, are_rows).into_iter();
    let head = rows.next().unwrap_or_default();
    let most = if is_short { NODES } else { usize::MAX };
    let left_out = rows.len().saturating_sub(most);
    let mut blocks = Vec::new();
    if !head.is_empty() {
        let table = Table::new(head.into_iter().map(Column::new), rows.take(most).map(Row::of));
        blocks.push(Block::Table(Table { is_framed: true, ..table }));
    }
    if left_out > 0 {
        blocks.push(Block::Text(format!("{left_out} more nodes{}", report.advice.rows)));
    }
    blocks.extend(silent.iter().filter(|(_, nodes)| !are_rows && !nodes.is_empty()).map(|(channel, nodes)| {
        let nodes = node_table::ranges(nodes);
        Block::Text(format!("{channel}never sent anything, but somebody addressed them: {nodes}"))
    }));
    blocks
}

/// The cases of certification runs. A short text has some of the cases that have not passed.
fn test_runs(report: &DiagnosisReport<'_>, depth: Depth) -> Option<Section> {
    const FAILED: usize = 8;
    let is_short = depth == Depth::Screen && !report.is_verbose;
    let mut blocks = Vec::new();
    let runs = report.diagnosed.results.buses.iter().map(|(_, bus)| &bus.test_run);
    for run in runs.filter(|run| !run.cases.is_empty()) {
        let passed = run.cases.iter().filter(|case| case.is_passed()).count();
        let all = run.cases.len() as u64 + run.omitted;
        blocks.push(Block::Text(format!("test run: {all} cases, {passed} passed")));
        let shown: Vec<&TestCase> = run.cases.iter().filter(|case| !is_short || !case.is_passed()).collect();
        let most = if is_short { FAILED } else { usize::MAX };
        let columns = ["case", "verdict"].map(Column::new).into_iter();
        let columns = columns.chain(["frames", "s"].map(Column::right)).chain([Column::new("where")]);
        let rows = shown.iter().take(most).map(|case| of_case(report.diagnosed, case));
        blocks.push(Block::Table(Table::new(columns, rows)));
        let left = shown.len().saturating_sub(most);
        if left > 0 {
            blocks.push(Block::Text(format!("{left} more have not passed{}", report.advice.rows)));
        }
    }
    (!blocks.is_empty()).then(|| section("test-run", "Test run", blocks))
}

/// A case of a certification run: its name, verdict, number of frames, begin in seconds, and place.
fn of_case(diagnosed: &Diagnosed<'_>, case: &TestCase) -> Row {
    let verdict = case.verdict.as_deref().unwrap_or("not ended");
    let places = format!("#{} to #{}", case.place.number, case.last_place.number);
    let (name, frames, at) = (case.name.to_string(), case.frames.to_string(), diagnosed.since_start(case.begin));
    let line = format!("  {name}: {verdict}, {frames} frames from {at} s, {places}");
    Row { lines: vec![line], ..Row::of([name, verdict.to_owned(), frames, at, places]) }
}
