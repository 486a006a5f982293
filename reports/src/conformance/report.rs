//! A conformance run as a report.

use super::case::{finding, rows_of};
use super::defects::defects;
use super::dictionary::{REPAIR, left, lines, rows, sentence};
use super::skipped::Skipped;
use super::{Run, front, host, is_bad, name_in_family, outcome, suites, symbol, tone};
use crate::conformance::json;
use crate::document::{
    Block, Cell, Code, Column, Depth, Document, Fact, PageParts, Report, Row, Section, Table, Tone, fact,
};
use crate::provenance::identity_facts;
use canvass_suite::comparison::Comparison;
use canvass_suite::foreign;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use maud::html;
use std::io::{self, Write};

const STYLES: [&str; 1] = [include_str!("../../assets/conformance.css")];
const SCRIPTS: [&str; 1] = [include_str!("../../assets/conformance.js")];

impl Report for Run {
    fn document(&self, depth: Depth) -> Document {
        let name = self.info.device.names[0].as_deref().unwrap_or("CANopen device");
        let failures = defects(self).iter().filter(|defect| defect.is_failure()).count();
        let is_good = self.summary.is_good() && self.comparison.as_ref().is_none_or(Comparison::is_as_found);
        Document {
            command: "test",
            kind: "CANopen conformance",
            title: format!("{name}: conformance of node {}", self.info.node),
            outcome: format!("{}, in {} on the bus", outcome(&self.summary, failures), self.summary.duration),
            tone: if is_good { Tone::Good } else { Tone::Bad },
            facts: if depth == Depth::Screen { Vec::new() } else { facts(self) },
            head: front::head(self),
            date: self.provenance.date.as_ref().map(|date| date.rfc3339.clone()).unwrap_or_default(),
            front: if depth < Depth::Print { Vec::new() } else { front::sections(self) },
            summary: summary(self, depth),
            sections: sections(self, depth),
            about: Some(self.provenance.section(depth, true)),
            suites: suites::of(self),
            page: PageParts {
                footer: "Times are those of the bus. A section that is not attested is marked.",
                styles: &STYLES,
                scripts: &SCRIPTS,
                data: None,
            },
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        json::render(self, out)
    }
}

fn facts(run: &Run) -> Vec<Fact> {
    let info = &run.info;
    let rate = info.bit_rate.map(|rate| format!(", {} kbit/s", rate / 1_000)).unwrap_or_default();
    let order = info.shuffle.map(|seed| format!("shuffled, seed {seed}")).unwrap_or_default();
    let of_run = [
        fact("node", &info.node),
        fact("bus", &format!("{}{rate}", info.bus)),
        fact("description", &info.model),
        fact("order of the cases", &order),
        fact("other clients", &foreign::told(&run.other_clients)),
    ];
    let of_device =
        identity_facts(&info.device).map(|(name, value)| fact(name, value.as_deref().unwrap_or("not given")));
    of_run.into_iter().chain(of_device).filter(|(_, value)| !value.is_empty()).collect()
}

/// The facts of the run as a whole. On a terminal they include the bad cases, because the last lines are seen first.
fn summary(run: &Run, depth: Depth) -> Vec<Block> {
    let mut blocks: Vec<Block> = run.summary.host.iter().map(|told| Block::Text(host::sentence(told))).collect();
    if let Some(comparison) = run.comparison.as_ref().filter(|_| depth == Depth::Screen) {
        blocks.push(Block::Items(lines(comparison)));
    }
    blocks.extend(run.notices.iter().cloned().map(Block::Note));
    if depth == Depth::Screen && bad(run).next().is_some() {
        blocks.extend([Block::Text(String::new()), failed(run, depth)]);
    }
    blocks
}

fn sections(run: &Run, depth: Depth) -> Vec<Section> {
    let (cases, not_needed) = (section("cases", "Cases", cases(run, depth)), needed(run, depth));
    let verdicts = section("verdicts", "Verdicts", vec![verdicts(run, depth)]);
    if depth == Depth::Screen {
        return vec![cases, section("needed", "", not_needed), verdicts];
    }
    let mut sections = vec![verdicts];
    if bad(run).next().is_some() {
        sections.push(section("failed", "Failed", vec![failed(run, depth)]));
    }
    if depth == Depth::Page {
        sections.push(section("matrix", "Matrix", vec![matrix(run)]));
    }
    let compared = run
        .comparison
        .iter()
        .map(|told| section("dictionary", "Object dictionary before and after", compared(run, told)));
    sections.extend(compared);
    if !not_needed.is_empty() {
        sections.push(section("needed", "What other cases would need", not_needed));
    }
    sections.push(cases);
    if matches!(depth, Depth::Paper | Depth::Print) {
        sections.push(section("all", "All cases", vec![all(run)]));
    }
    sections
}

fn section(id: &'static str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id, title: title.to_owned(), blocks }
}

/// The number of cases by verdict. On a page each number is a button that shows only these cases.
fn verdicts(run: &Run, depth: Depth) -> Block {
    if depth == Depth::Page {
        return Block::Markup(html! {
            div.tiles role="group" aria-label="Verdicts" { @for kind in Kind::ALL {
                @let count = run.summary.count(kind);
                button.tile.(kind.name()) type="button" data-kind=(kind.name()) aria-pressed="false" disabled[count == 0] {
                    span.count { (count) }
                    span.name { span aria-hidden="true" { (symbol(kind)) " " } (kind.title()) }
                }
            } }
        });
    }
    let row = |kind: Kind| {
        let count = run.summary.count(kind);
        let tone = if count > 0 { tone(kind) } else { Tone::Plain };
        Row::of([Cell { tone, ..format!("{} {kind}", symbol(kind)).into() }, count.to_string().into()])
    };
    let columns = [Column::new("verdict"), Column::right("cases")];
    Block::Table(Table { is_framed: true, ..Table::new(columns, Kind::ALL.map(row)) })
}

/// The cases that somebody has to look into.
fn bad(run: &Run) -> impl Iterator<Item = &CaseReport> {
    run.cases.iter().filter(|report| is_bad(report.verdict.kind()))
}

/// A table of the bad cases with their reasons, each linked to its details. The cases of a defect follow each other; a
/// terminal has one line for them and one with their names.
fn failed(run: &Run, depth: Depth) -> Block {
    let rows = defects(run).into_iter().flat_map(|defect| rows_of(&defect, depth));
    Block::Table(Table::of(["verdict", "case", "why"], rows))
}

fn matrix(run: &Run) -> Block {
    Block::Markup(html! {
        div.matrix {
            @for (name, group) in run.families() {
                div.family { (name) }
                div.cells {
                    @for report in group {
                        @let kind = report.verdict.kind();
                        a.cell.(kind.name()) href={ "#" (super::case::anchor(report)) }
                            title={ (report.case.id) ": " (kind.title()) } {
                            span aria-hidden="true" { (symbol(kind)) } " " (name_in_family(report.case.id))
                        }
                    }
                }
            }
        }
    })
}

fn compared(run: &Run, comparison: &Comparison) -> Vec<Block> {
    let told = sentence(comparison);
    let mut blocks = vec![if comparison.is_as_found() { Block::Text(told) } else { Block::Note(told) }];
    if let Some(comparison) = left(run) {
        blocks.push(Block::Table(Table::of(["object", "name", "before", "after"], rows(comparison).map(Row::of))));
        if !comparison.commands.is_empty() {
            let text = comparison.commands.join("\n");
            blocks.extend([Block::Text(REPAIR.to_owned()), Block::Code(Code { title: "", language: "sh", text })]);
        }
    }
    blocks
}

/// The features that a device or its description lacks, with the cases that did not apply for this reason.
fn needed(run: &Run, depth: Depth) -> Vec<Block> {
    let skipped = Skipped::of(run);
    let group = |(reason, cases)| Block::fold(reason, vec![Block::Words(cases)]);
    let blocks: Vec<Block> = skipped.groups(run.allow).into_iter().map(group).collect();
    match depth {
        Depth::Screen if !blocks.is_empty() => {
            vec![Block::fold("not applicable", blocks)]
        }
        _ => blocks,
    }
}

/// The cases. A page has all cases; cases that failed or could not be judged come first. Other forms have only the
/// cases that did not simply pass.
fn cases(run: &Run, depth: Depth) -> Vec<Block> {
    let is_told = |report: &CaseReport| match report.verdict.kind() {
        Kind::Pass => report.is_flaky() || depth == Depth::Screen && !report.notes.is_empty(),
        kind => kind != Kind::NotApplicable,
    };
    let block = |report: &CaseReport| Block::Finding(finding(report, depth));
    if depth < Depth::Page {
        return run.cases.iter().filter(|report| is_told(report)).map(block).collect();
    }
    let others = run.cases.iter().filter(|report| !is_bad(report.verdict.kind()));
    [filter()].into_iter().chain(bad(run).chain(others).map(block)).collect()
}

fn filter() -> Block {
    Block::Markup(html! {
        div.filter {
            input #filter type="search" placeholder="Filter by id, clause or text" aria-label="Filter";
            span #shown aria-live="polite" {}
        }
    })
}

fn all(run: &Run) -> Block {
    let row = |report: &CaseReport| {
        let kind = report.verdict.kind();
        Row::of([symbol(kind).to_owned(), report.case.id.to_owned(), report.case.clause.to_string(), kind.to_string()])
    };
    Block::Table(Table::of(["", "case", "clause", "verdict"], run.cases.iter().map(row)))
}
