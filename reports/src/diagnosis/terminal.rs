//! The diagnosis on a terminal: what was on the bus, what was wrong with it, and each node in figures.

use super::{Diagnosed, frame, times};
use crate::escape::printable;
use canvass_analyzer::NodeId;
use canvass_analyzer::findings::{Finding, Severity};
use canvass_analyzer::statistics::{BusStatistics, NodeStatistics, TestCase};
use canvass_traces::Duration;
use comfy_table::{ContentArrangement, Table, presets};
use std::io::{self, Write};

/// How to print.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Style {
    /// With colours.
    pub color: bool,
    /// The width of the terminal in columns, where it is one.
    pub width: Option<u16>,
}

/// Prints the diagnosis.
///
/// # Errors
/// What `out` gives.
pub fn render(diagnosed: &Diagnosed<'_>, style: Style, out: &mut dyn Write) -> io::Result<()> {
    for line in summary(diagnosed) {
        writeln!(out, "{}", printable(&line))?;
    }
    for finding in &diagnosed.results.findings {
        show(diagnosed, finding, style, out)?;
    }
    for (rule, count) in &diagnosed.results.omitted {
        writeln!(out, "\n{rule}: {count} more, which are not shown")?;
    }
    let rows = nodes(diagnosed);
    if !rows.is_empty() {
        writeln!(out, "\n{}", table(&rows, style))?;
    }
    cases(diagnosed, out)?;
    out.flush()
}

/// What was on the buses and how many findings there are, in a few lines.
pub fn summary(diagnosed: &Diagnosed<'_>) -> Vec<String> {
    let mut lines: Vec<String> = diagnosed
        .results
        .buses
        .iter()
        .map(|(id, bus)| format!("{}: {}", diagnosed.channel(*id), of_bus(bus)))
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
fn of_bus(bus: &BusStatistics) -> String {
    let present: Vec<String> =
        bus.nodes.iter().filter(|(_, node)| node.present).map(|(id, _)| id.to_string()).collect();
    let nodes = match present.len() {
        0 => "no node sent anything".to_owned(),
        1 => format!("1 node ({})", present.join(", ")),
        n => format!("{n} nodes ({})", present.join(", ")),
    };
    let rate = bus.bit_rate_text().unwrap_or_else(|| "bit rate not known (see --bit-rate)".to_owned());
    let load = match (bus.mean_load(), bus.peak_load()) {
        (Some(mean), Some((_, peak))) => format!(", load {mean:.1} % (peak {peak:.1} %)"),
        _ => String::new(),
    };
    format!("{} frames in {}, {nodes}, {rate}{load}", bus.total(), rounded(bus.duration()))
}

/// `507 / 884 / 899 / 899 µs`: the unit is said once where all have the same.
fn joined(times: &[String]) -> String {
    let unit = times.last().and_then(|last| last.split_once(' ')).map(|(_, unit)| format!(" {unit}"));
    let bare: Option<Vec<&str>> =
        unit.as_ref().and_then(|unit| times.iter().map(|time| time.strip_suffix(unit)).collect());
    match (bare, unit) {
        (Some(bare), Some(unit)) => format!("{}{unit}", bare.join(" / ")),
        _ => times.join(" / "),
    }
}

/// A time that nobody wants to the last digit.
pub(super) fn rounded(time: Duration) -> Duration {
    let unit = match time.nanos() {
        0..1_000_000 => 1_000,
        1_000_000..1_000_000_000 => 10_000,
        _ => 1_000_000,
    };
    Duration(time.nanos() / unit * unit)
}

fn painted(severity: Severity, text: &str, style: Style) -> String {
    let code = match severity {
        Severity::Error => "1;31",
        Severity::Warning => "33",
        Severity::Info => "36",
    };
    if style.color { format!("\x1b[{code}m{text}\x1b[0m") } else { text.to_owned() }
}

fn show(diagnosed: &Diagnosed<'_>, finding: &Finding, style: Style, out: &mut dyn Write) -> io::Result<()> {
    let severity = painted(finding.severity, finding.severity.name(), style);
    let whom = diagnosed.whom(finding);
    let whom = if whom.is_empty() { whom } else { format!("{}: ", printable(&whom)) };
    writeln!(out, "\n{severity}  {whom}{}  [{}]", finding.rule.title, finding.rule.id)?;
    let at = diagnosed.since_start(finding.first);
    writeln!(out, "  at {at} s: {}{}", printable(&finding.message), times(diagnosed, finding))?;
    for exhibit in &finding.evidence {
        let (place, at) = (diagnosed.place(exhibit), diagnosed.since_start(exhibit.time));
        let line = format!("{place}  {at}  {:<21} {}", frame(exhibit), exhibit.text);
        writeln!(out, "    {}", printable(line.trim_end()))?;
    }
    writeln!(out, "  {}", finding.rule.advice)
}

/// The head of the table of nodes and its rows; empty where there are no nodes.
pub fn nodes(diagnosed: &Diagnosed<'_>) -> Vec<Vec<String>> {
    let buses = &diagnosed.results.buses;
    let several = buses.len() > 1;
    let mut rows = Vec::new();
    for (channel, bus) in buses {
        for (id, node) in bus.nodes.iter().filter(|(_, node)| node.total() > 0) {
            let mut row = of_node(*id, node, bus);
            if several {
                row.insert(0, printable(&diagnosed.channel(*channel)).into_owned());
            }
            rows.push(row);
        }
    }
    if rows.is_empty() {
        return rows;
    }
    let mut head: Vec<String> = HEAD.iter().map(|&name| name.to_owned()).collect();
    if several {
        head.insert(0, "channel".to_owned());
    }
    rows.insert(0, head);
    rows
}

const HEAD: [&str; 9] = [
    "node",
    "who",
    "frames",
    "load/peak %",
    "last state",
    "boots",
    "EMCY",
    "SDO done/aborted",
    "response p50/p95/p99/max",
];

fn of_node(id: NodeId, node: &NodeStatistics, bus: &BusStatistics) -> Vec<String> {
    let state = node.states.last().map(|change| change.state.to_string());
    let emcy: u64 = node.emcy.iter().filter(|row| !row.code.is_reset()).map(|row| row.count).sum();
    let times = &node.responses;
    // Without times in the capture all are zero.
    let shown = [times.quantile(50), times.quantile(95), times.quantile(99), times.max()];
    let response = match times.max() {
        Some(max) if max > Duration::ZERO => {
            joined(&shown.into_iter().flatten().map(|time| rounded(time).to_string()).collect::<Vec<_>>())
        }
        _ => String::new(),
    };
    let peak = bus.bit_rate.and_then(|bit_rate| node.peak.percent(bit_rate));
    let load = match (bus.share_of_load(node.bits), peak) {
        (Some(mean), Some((_, peak))) => format!("{mean:.1} / {peak:.1}"),
        _ => String::new(),
    };
    vec![
        id.to_string(),
        printable(&who(node)).into_owned(),
        node.total().to_string(),
        load,
        state.unwrap_or_default(),
        node.boot_ups.to_string(),
        emcy.to_string(),
        format!("{}/{}", node.completed, node.aborted),
        response,
    ]
}

/// Who a node is, as far as it was read from it.
pub(super) fn who(node: &NodeStatistics) -> String {
    let identity = &node.identity;
    let [vendor, product, _, serial] = identity.numbers;
    let mut parts: Vec<String> = identity.names[0].iter().cloned().collect();
    parts.extend(identity.names[2].iter().map(|version| format!("software {version}")));
    parts.extend(vendor.map(|vendor| format!("vendor {vendor:X}h")));
    parts.extend(product.map(|product| format!("product {product:X}h")));
    parts.extend(serial.map(|serial| format!("serial {serial:X}h")));
    if parts.is_empty() {
        parts.extend(identity.device_type.map(|device| format!("profile {}", device & 0xFFFF)));
    }
    if !node.present {
        parts.push("never sent anything".to_owned());
    }
    parts.join(", ")
}

fn table(rows: &[Vec<String>], style: Style) -> Table {
    let mut table = Table::new();
    table.load_style(presets::UTF8_FULL_CONDENSED).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(style.width.unwrap_or(120)).force_no_tty();
    if let Some((head, rows)) = rows.split_first() {
        table.set_header(head);
        table.add_rows(rows);
    }
    table
}

/// The cases of a certification run.
fn cases(diagnosed: &Diagnosed<'_>, out: &mut dyn Write) -> io::Result<()> {
    for (_, bus) in &diagnosed.results.buses {
        let run = &bus.test_run;
        if run.cases.is_empty() {
            continue;
        }
        writeln!(out, "\nCiA test run: {} cases", run.cases.len() as u64 + run.omitted)?;
        for case in &run.cases {
            let [name, verdict, frames, at, places] = of_case(diagnosed, case);
            writeln!(out, "  {name}: {verdict}, {frames} frames from {at} s, {places}")?;
        }
    }
    Ok(())
}

/// A case of a certification run: its name, verdict, number of frames, begin in seconds, and where it stands.
pub fn of_case(diagnosed: &Diagnosed<'_>, case: &TestCase) -> [String; 5] {
    let verdict = case.verdict.map_or_else(|| "not ended".to_owned(), |verdict| verdict.to_string());
    let places = format!("#{} to #{}", case.place.number, case.last_place.number);
    let name = format!("group {} case {}", case.group, case.case);
    [name, verdict, case.frames.to_string(), diagnosed.since_start(case.begin), places]
}
