//! The findings of a diagnosis with their consequences.

use super::report::DiagnosisReport;
use super::story::{self, Told};
use super::{Diagnosed, frame, times};
use crate::document::{Block, Column, Depth, Finding, Row, Table, Tone, height};
use canvass_analyzer::findings::{self, Exhibit, Severity};
use std::collections::HashSet;

/// The detail in which a story is shown.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Detail {
    /// Every finding with all its frames.
    Verbose,
    /// The first finding with the frames that prove it, and its consequences.
    Full,
    /// The first finding and its first consequences.
    Short,
    Line,
}

/// The stories of a diagnosis. On a terminal with `room` lines they are shown in full if they fit, or else in short. If
/// they do not fit in short either, the first are in short, the next in one line each, and the rest is counted.
pub fn blocks(report: &DiagnosisReport<'_>, depth: Depth, room: usize) -> Vec<Block> {
    let diagnosed = report.diagnosed;
    let all: Vec<Told<'_>> = story::all(diagnosed).collect();
    let told = |detail| -> Vec<Block> {
        let mut advised = HashSet::new();
        all.iter().flat_map(|told| of_story(diagnosed, told, detail, &mut advised)).collect()
    };
    if depth > Depth::Screen {
        return all.iter().flat_map(|told| in_full(diagnosed, told)).collect();
    }
    if report.is_verbose {
        return told(Detail::Verbose);
    }
    let fitting = [Detail::Full, Detail::Short].map(told).into_iter().find(|blocks| height(blocks) <= room);
    fitting.unwrap_or_else(|| shortened(report, &all, room))
}

/// The first stories in short, the others in one line each, and the number of stories for which there is no room.
fn shortened(report: &DiagnosisReport<'_>, all: &[Told<'_>], room: usize) -> Vec<Block> {
    let diagnosed = report.diagnosed;
    let mut advised = HashSet::new();
    let (mut blocks, mut used) = (Vec::new(), 0);
    for (at, told) in all.iter().enumerate() {
        let left = all.len() - at - 1;
        let mut advised_here = advised.clone();
        let short: Vec<Block> = of_story(diagnosed, told, Detail::Short, &mut advised_here).into_iter().collect();
        // Each remaining story needs a line, as far as half of the room allows.
        if used + height(&short) + left.min(room / 2) < room {
            advised = advised_here;
            used += height(&short);
            blocks.extend(short);
            continue;
        }
        if used + 2 >= room && left > 0 {
            blocks.push(Block::Text(format!("{} more{}", left + 1, report.advice.findings)));
            return blocks;
        }
        used += 1;
        blocks.extend(of_story(diagnosed, told, Detail::Line, &mut advised));
    }
    blocks
}

const fn tone(severity: Severity) -> Tone {
    match severity {
        Severity::Error => Tone::Bad,
        Severity::Warning => Tone::Doubt,
        Severity::Info => Tone::Info,
    }
}

/// The node before a colon: `node 5: `. Empty if there is none.
fn prefix(whom: String) -> String {
    if whom.is_empty() { whom } else { whom + ": " }
}

/// A story on a terminal. Advice that an earlier story gave is not repeated.
fn of_story(
    diagnosed: &Diagnosed<'_>,
    told: &Told<'_>,
    detail: Detail,
    advised: &mut HashSet<&'static str>,
) -> Option<Block> {
    let head = told.head();
    let (first, severity) = (head.first()?, told.severity());
    let (whom, at) = (prefix(story::whom(diagnosed, &head)), diagnosed.since_start(first.first));
    let (words, rule) = (story::words(diagnosed, &head), first.rule);
    if detail == Detail::Line {
        let line = format!("{}  {whom}at {at} s: {words}  [{}]", severity.name(), rule.id);
        let row = Row { tone: tone(severity), lines: vec![line], ..Row::default() };
        return Some(Block::Table(Table::new([], [row])));
    }
    let mut body = match detail {
        Detail::Verbose => head.iter().flat_map(|finding| with_frames(diagnosed, finding)).collect(),
        _ => vec![Block::Text(format!("at {at} s: {words}"))],
    };
    let (evidence, consequences) = match detail {
        Detail::Full => (4, 8),
        Detail::Short => (0, 2),
        _ => (0, usize::MAX),
    };
    body.push(proof(diagnosed, first.evidence.iter().take(evidence)));
    let advice = Some(rule.advice).filter(|_| advised.insert(rule.id));
    body.extend(advice.map(|advice| Block::Text(advice.to_owned())));
    for (_, findings) in told.consequences().take(consequences) {
        body.extend(of_consequence(diagnosed, &findings, detail));
    }
    let left = told.consequences().count().saturating_sub(consequences);
    body.extend((left > 0).then(|| Block::Text(format!("then {left} more that follow from it"))));
    let title = format!("{whom}{}", rule.title);
    let (badge, id) = (severity.name().to_owned(), rule.id.to_owned());
    Some(Block::Finding(Finding { tone: tone(severity), badge, title, id, body, ..Finding::default() }))
}

/// A consequence of the head of a story, in one line or with all frames.
fn of_consequence(diagnosed: &Diagnosed<'_>, findings: &[&findings::Finding], detail: Detail) -> Vec<Block> {
    let Some(first) = findings.first() else { return Vec::new() };
    let (whom, rule) = (prefix(story::whom(diagnosed, findings)), first.rule);
    if detail == Detail::Verbose {
        let blocks = findings.iter().flat_map(|finding| with_frames(diagnosed, finding)).collect();
        return vec![Block::fold(format!("then {whom}{}  [{}]", rule.title, rule.id), blocks)];
    }
    let (at, words) = (diagnosed.since_start(first.first), story::words(diagnosed, findings));
    vec![Block::Text(format!("then at {at} s: {whom}{words}  [{}]", rule.id))]
}

/// The time, the words and the number of a finding, and all frames that prove it.
fn with_frames(diagnosed: &Diagnosed<'_>, finding: &findings::Finding) -> Vec<Block> {
    let at = diagnosed.since_start(finding.first);
    let told = Block::Text(format!("at {at} s: {}{}", finding.message, times(diagnosed, finding)));
    if finding.evidence.is_empty() { vec![told] } else { vec![told, proof(diagnosed, finding.evidence.iter())] }
}

/// The frames that prove a finding.
fn proof<'e>(diagnosed: &Diagnosed<'_>, exhibits: impl Iterator<Item = &'e Exhibit>) -> Block {
    let row = |exhibit: &Exhibit| {
        let (place, at) = (diagnosed.place(exhibit), diagnosed.since_start(exhibit.time));
        Row::of([place, at, frame(exhibit), exhibit.text.clone()])
    };
    let columns = [Column::new("where"), Column::right("s"), Column::new("frame"), Column::new("meaning")];
    Block::Table(Table::new(columns, exhibits.map(row)))
}

/// Every finding of a story with all its frames, and the finding from which it follows.
fn in_full(diagnosed: &Diagnosed<'_>, told: &Told<'_>) -> Vec<Block> {
    let heads = told.head().into_iter().map(|finding| (finding, None));
    let rest = told.consequences().flat_map(|(consequence, findings)| {
        let cause = diagnosed.results.findings.get(consequence.of);
        findings.into_iter().map(move |finding| (finding, cause))
    });
    heads.chain(rest).map(|(finding, cause)| Block::Finding(one(diagnosed, finding, cause))).collect()
}

fn one(diagnosed: &Diagnosed<'_>, finding: &findings::Finding, cause: Option<&findings::Finding>) -> Finding {
    let titled = |finding| format!("{}{}", prefix(diagnosed.whom(finding)), finding.rule.title);
    let mut body: Vec<Block> =
        cause.map(|cause| Block::Text(format!("This follows from: {}.", titled(cause)))).into_iter().collect();
    body.extend(with_frames(diagnosed, finding));
    body.push(Block::Text(finding.rule.advice.to_owned()));
    Finding {
        tone: tone(finding.severity),
        badge: finding.severity.to_string(),
        title: titled(finding),
        id: finding.rule.id.to_owned(),
        body,
        ..Finding::default()
    }
}
