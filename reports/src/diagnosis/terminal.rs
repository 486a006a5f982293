//! The diagnosis on a terminal: what was on the bus, what was wrong with it, and each node in figures.

use super::node_table::{self, rounded};
use super::story::{self, Told};
use super::{Diagnosed, frame, times};
use crate::color::Color;
use crate::escape::{Visible, printable};
use crate::provenance;
use canvass_analyzer::findings::{Exhibit, Finding, Severity};
use canvass_analyzer::statistics::{BusStatistics, TestCase};
use comfy_table::Table;
use std::collections::HashSet;
use std::io::{self, Write};

/// How to print.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Style {
    /// With colours.
    pub color: bool,
    /// The width of the terminal in columns, where it is one.
    pub width: Option<u16>,
    /// Every finding with all its frames, and every node.
    pub verbose: bool,
    /// How to see what the table leaves out.
    pub advice: Advice,
}

/// How a user of the program sees more: it knows what its options are called. Nothing is said where a text is empty.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug)]
pub struct Advice {
    /// Follows the number of findings that are not shown.
    pub findings: &'static str,
    /// Follows the number of nodes or cases that are not shown.
    pub rows: &'static str,
    /// Follows the words that say that no bit rate is known.
    pub bit_rate: &'static str,
}

/// How much is said of a story.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Detail {
    /// Every finding with its frames.
    Verbose,
    /// What follows, and the frames that prove it.
    Full,
    /// What follows first of all.
    Short,
    Line,
}

/// So many lines are printed at most, unless all is asked for: what fits on a screen or a page of paper.
const LINES: usize = 58;
/// So many nodes are in the table then.
const NODES: usize = 16;

/// Prints the diagnosis.
///
/// # Errors
/// What `out` gives.
pub fn render(diagnosed: &Diagnosed<'_>, style: Style, out: &mut dyn Write) -> io::Result<()> {
    let out: &mut dyn Write = &mut Visible::new(out, style.color);
    let head: Vec<String> = summary(diagnosed, style.advice).iter().map(|line| printable(line).into_owned()).collect();
    let mut tail: Vec<String> = Vec::new();
    for (rule, count) in &diagnosed.results.omitted {
        tail.extend([String::new(), format!("{rule}: {count} more, which are not shown")]);
    }
    nodes(diagnosed, style, &mut tail);
    cases(diagnosed, style, &mut tail);
    tail.push(String::new());
    if style.verbose {
        let mut all = Vec::new();
        provenance::text(diagnosed.provenance, &mut all)?;
        tail.extend(String::from_utf8_lossy(&all).lines().map(str::to_owned));
    } else {
        tail.extend(provenance::short_text(diagnosed.provenance));
    }
    let room = LINES.saturating_sub(head.len() + tail.len());
    let stories = if style.verbose { verbose(diagnosed, style) } else { stories(diagnosed, style, room) };
    // What must be known comes first; what was on the bus after it.
    let stories = stories.iter().skip_while(|line| line.is_empty());
    let between = (!diagnosed.results.stories.is_empty()).then_some("");
    for line in stories.map(String::as_str).chain(between).chain(head.iter().chain(&tail).map(String::as_str)) {
        writeln!(out, "{line}")?;
    }
    out.flush()
}

/// Every finding with all its frames, what follows below what it follows from.
fn verbose(diagnosed: &Diagnosed<'_>, style: Style) -> Vec<String> {
    let mut advised = HashSet::new();
    let mut lines = Vec::new();
    for told in story::all(diagnosed) {
        lines.extend(of_story(diagnosed, &told, Detail::Verbose, style, &mut advised));
    }
    lines
}

/// The stories in so many lines: in full if they fit, then in short, then the last ones in a line each.
fn stories(diagnosed: &Diagnosed<'_>, style: Style, room: usize) -> Vec<String> {
    for detail in [Detail::Full, Detail::Short] {
        let mut advised = HashSet::new();
        let lines: Vec<String> =
            story::all(diagnosed).flat_map(|told| of_story(diagnosed, &told, detail, style, &mut advised)).collect();
        if lines.len() <= room {
            return lines;
        }
    }
    let all: Vec<Told<'_>> = story::all(diagnosed).collect();
    let mut advised = HashSet::new();
    let mut lines = Vec::new();
    for (at, told) in all.iter().enumerate() {
        let left = all.len() - at - 1;
        let mut advised_here = advised.clone();
        let short = of_story(diagnosed, told, Detail::Short, style, &mut advised_here);
        // Each of the others wants a line, as far as there is room for half of them.
        if lines.len() + short.len() + left.min(room / 2) < room {
            advised = advised_here;
            lines.extend(short);
            continue;
        }
        if lines.len() + 2 >= room && left > 0 {
            lines.push(format!("{} more{}", left + 1, style.advice.findings));
            return lines;
        }
        lines.extend(of_story(diagnosed, told, Detail::Line, style, &mut advised));
    }
    lines
}

/// The lines of a story; advice that was given before is not repeated.
fn of_story(
    diagnosed: &Diagnosed<'_>,
    told: &Told<'_>,
    detail: Detail,
    style: Style,
    advised: &mut HashSet<&'static str>,
) -> Vec<String> {
    let head = told.head();
    let Some(first) = head.first() else { return Vec::new() };
    let severity = Color::of_severity(told.severity()).paint(told.severity().name(), style.color);
    let whom = story::whom(diagnosed, &head);
    let whom = if whom.is_empty() { whom } else { format!("{}: ", printable(&whom)) };
    let at = diagnosed.since_start(first.first);
    let words = story::words(diagnosed, &head);
    if detail == Detail::Line {
        return vec![format!("{severity}  {whom}at {at} s: {}  [{}]", printable(&words), first.rule.id)];
    }
    let mut lines = vec![String::new(), format!("{severity}  {whom}{}  [{}]", first.rule.title, first.rule.id)];
    if detail == Detail::Verbose {
        lines.extend(head.iter().flat_map(|finding| in_full(diagnosed, finding)));
    } else {
        lines.push(format!("  at {at} s: {}", printable(&words)));
    }
    let (evidence, consequences) = match detail {
        Detail::Full => (4, 8),
        Detail::Short => (0, 2),
        _ => (0, usize::MAX),
    };
    lines.extend(first.evidence.iter().take(evidence).map(|exhibit| proof(diagnosed, exhibit)));
    let advice = Some(first.rule.advice).filter(|_| advised.insert(first.rule.id));
    lines.extend(advice.map(|advice| format!("  {advice}")));
    for (_, findings) in told.consequences().take(consequences) {
        lines.extend(of_consequence(diagnosed, &findings, detail));
    }
    let left = told.consequences().count().saturating_sub(consequences);
    if left > 0 {
        lines.push(format!("  then {left} more that follow from it"));
    }
    lines
}

/// What follows from the head of a story, in a line, or in full.
fn of_consequence(diagnosed: &Diagnosed<'_>, findings: &[&Finding], detail: Detail) -> Vec<String> {
    let Some(first) = findings.first() else { return Vec::new() };
    let whom = story::whom(diagnosed, findings);
    let whom = if whom.is_empty() { whom } else { format!("{}: ", printable(&whom)) };
    let (at, rule) = (diagnosed.since_start(first.first), first.rule);
    if detail == Detail::Verbose {
        let mut lines = vec![format!("  then {whom}{}  [{}]", rule.title, rule.id)];
        lines.extend(findings.iter().flat_map(|finding| in_full(diagnosed, finding)));
        return lines;
    }
    let words = story::words(diagnosed, findings);
    vec![format!("  then at {at} s: {whom}{}  [{}]", printable(&words), rule.id)]
}

/// A finding with all frames that prove it.
fn in_full(diagnosed: &Diagnosed<'_>, finding: &Finding) -> Vec<String> {
    let at = diagnosed.since_start(finding.first);
    let mut lines = vec![format!("  at {at} s: {}{}", printable(&finding.message), times(diagnosed, finding))];
    lines.extend(finding.evidence.iter().map(|exhibit| proof(diagnosed, exhibit)));
    lines
}

/// A frame that proves something.
fn proof(diagnosed: &Diagnosed<'_>, exhibit: &Exhibit) -> String {
    let (place, at) = (diagnosed.place(exhibit), diagnosed.since_start(exhibit.time));
    let line = format!("{place}  {at}  {:<21} {}", frame(exhibit), exhibit.text);
    format!("    {}", printable(line.trim_end()))
}

/// What was on the buses and how many findings there are, in a few lines.
pub fn summary(diagnosed: &Diagnosed<'_>, advice: Advice) -> Vec<String> {
    let mut lines: Vec<String> = diagnosed
        .results
        .buses
        .iter()
        .map(|(id, bus)| format!("{}: {}", diagnosed.channel(*id), of_bus(bus, advice)))
        .collect();
    if diagnosed.results.unwatched > 0 {
        lines.push(format!("{} frames of further channels were not looked at", diagnosed.results.unwatched));
    }
    let count = |severity, one: &str, many: &str| match diagnosed.count(severity) {
        1 => format!("1 {one}"),
        n => format!("{n} {many}"),
    };
    let [errors, warnings] =
        [count(Severity::Error, "error", "errors"), count(Severity::Warning, "warning", "warnings")];
    lines.push(format!("{errors}, {warnings}, {}", count(Severity::Info, "hint", "hints")));
    lines
}

/// `12000 frames in 30 s, 4 nodes (1, 3, 4, 6), 500 kbit/s (inferred), load 4.0 % (peak 7.0 %)`.
fn of_bus(bus: &BusStatistics, advice: Advice) -> String {
    let present: Vec<String> =
        bus.nodes.iter().filter(|(_, node)| node.present).map(|(id, _)| id.to_string()).collect();
    let nodes = match present.len() {
        0 => "no node sent anything".to_owned(),
        1 => format!("1 node ({})", present.join(", ")),
        n => format!("{n} nodes ({})", present.join(", ")),
    };
    let rate = bus.bit_rate_text().unwrap_or_else(|| format!("bit rate not known{}", advice.bit_rate));
    let load = match (bus.mean_load(), bus.peak_load()) {
        (Some(mean), Some((_, peak))) => format!(", load {mean:.1} % (peak {peak:.1} %)"),
        _ => String::new(),
    };
    format!("{} frames in {}, {nodes}, {rate}{load}", bus.total(), rounded(bus.duration()))
}

/// The table of nodes. Of a scan for nodes there are many that never sent anything: they are named in one line.
fn nodes(diagnosed: &Diagnosed<'_>, style: Style, lines: &mut Vec<String>) {
    const SILENT: usize = 3;
    let silent = node_table::silent(diagnosed);
    let are_rows = style.verbose || silent.iter().map(|(_, nodes)| nodes.len()).sum::<usize>() <= SILENT;
    let mut rows = node_table::rows(diagnosed, are_rows);
    let left_out = rows.len().saturating_sub(NODES + 1);
    if !style.verbose {
        rows.truncate(NODES + 1);
    }
    if !rows.is_empty() {
        lines.push(String::new());
        lines.extend(table(&rows, style).to_string().lines().map(str::to_owned));
    }
    if left_out > 0 && !style.verbose {
        lines.push(format!("{left_out} more nodes{}", style.advice.rows));
    }
    for (channel, nodes) in silent.iter().filter(|(_, nodes)| !are_rows && !nodes.is_empty()) {
        let whole = format!("{channel}never sent anything, but somebody addressed them: {}", node_table::ranges(nodes));
        lines.push(printable(&whole).into_owned());
    }
}

fn table(rows: &[Vec<String>], style: Style) -> Table {
    let mut table = crate::table::table(style.width.unwrap_or(120), false);
    if let Some((head, rows)) = rows.split_first() {
        table.set_header(head);
        table.add_rows(rows);
    }
    table
}

/// The cases of a certification run: those that have not passed, or all.
fn cases(diagnosed: &Diagnosed<'_>, style: Style, lines: &mut Vec<String>) {
    const FAILED: usize = 8;
    for (_, bus) in &diagnosed.results.buses {
        let run = &bus.test_run;
        if run.cases.is_empty() {
            continue;
        }
        let passed = run.cases.iter().filter(|case| case.is_passed()).count();
        let all = run.cases.len() as u64 + run.omitted;
        lines.extend([String::new(), format!("test run: {all} cases, {passed} passed")]);
        let shown = run.cases.iter().filter(|case| style.verbose || !case.is_passed());
        let most = if style.verbose { usize::MAX } else { FAILED };
        let left = shown.clone().count().saturating_sub(most);
        for case in shown.take(most) {
            let [name, verdict, frames, at, places] = of_case(diagnosed, case);
            lines.push(format!("  {name}: {verdict}, {frames} frames from {at} s, {places}"));
        }
        if left > 0 {
            lines.push(format!("  {left} more have not passed{}", style.advice.rows));
        }
    }
}

/// A case of a certification run: its name, verdict, number of frames, begin in seconds, and where it stands.
pub fn of_case(diagnosed: &Diagnosed<'_>, case: &TestCase) -> [String; 5] {
    let verdict = case.verdict.as_deref().unwrap_or("not ended").to_owned();
    let places = format!("#{} to #{}", case.place.number, case.last_place.number);
    [case.name.to_string(), verdict, case.frames.to_string(), diagnosed.since_start(case.begin), places]
}
