//! The history as a report: the matrix of cases and releases, and times over the releases.

use super::{Course, History, ReleaseRow, json, sign};
use crate::document::{Align, Block, Cell, Column, Depth, Document, PageParts, Report, Row, Section, Table};
use crate::results::history::{self, Release};
use maud::html;
use serde_json::Value;
use std::io::{self, Write};

const STYLES: [&str; 2] = [include_str!("../../assets/uplot/uPlot.min.css"), include_str!("../../assets/history.css")];
const SCRIPTS: [&str; 2] =
    [include_str!("../../assets/uplot/uPlot.iife.min.js"), include_str!("../../assets/history.js")];

impl Report for History {
    fn document(&self, depth: Depth) -> Document {
        let changed = matrix(self, self.telling());
        let mut sections = vec![
            section("releases", "Releases", vec![releases(self)]),
            section("changed", "What changed", vec![changed]),
        ];
        if depth == Depth::Page {
            let all = matrix(self, self.cases.iter().map(|row| (row, row.course())));
            let all = Block::fold(format!("{} cases", self.cases.len()), vec![all]);
            sections.push(section("matrix", "All cases", vec![all]));
            sections.push(section("times", "Times", vec![times()]));
        }
        Document {
            command: "history",
            kind: "CANopen conformance",
            title: "History".to_owned(),
            outcome: self.outcome(),
            sections,
            about: Some(self.provenance.section(depth, depth > Depth::Screen)),
            page: PageParts {
                footer: "Releases stand in the order in which they were given. ",
                styles: &STYLES,
                scripts: &SCRIPTS,
                data: (depth == Depth::Page).then(|| series(self)),
            },
            ..Document::default()
        }
    }

    fn json(&self, out: &mut dyn Write) -> io::Result<()> {
        json::render(self, out)
    }
}

fn section(id: &'static str, title: &str, blocks: Vec<Block>) -> Section {
    Section { id, title: title.to_owned(), blocks }
}

fn releases(history: &History) -> Block {
    let row = |(at, release): (usize, &Release)| {
        let cancelled = if release.cancelled { ", a run was cancelled" } else { "" };
        let (software, results) = (release.software.join(", "), release.samples);
        let line = format!("{:>3}  {}: software {software}, {results} results{cancelled}", at + 1, release.name);
        Row { lines: vec![line], ..Row::of([release.name.clone(), software, format!("{results}{cancelled}")]) }
    };
    Block::Table(Table::of(["release", "software", "results"], history.releases.iter().enumerate().map(row)))
}

fn matrix<'a>(history: &History, rows: impl Iterator<Item = (&'a ReleaseRow, Course)>) -> Block {
    let names = history.releases.iter().map(|release| Column { align: Align::Center, ..Column::new(&release.name) });
    let columns = [Column::new("case")].into_iter().chain(names).chain([Column::new("")]);
    let mut table = Table::new(columns, rows.map(|(row, course)| line(history, row, &course)));
    table.class = "history";
    if table.rows.is_empty() { Block::Text("Nothing.".to_owned()) } else { Block::Table(table) }
}

fn line(history: &History, row: &ReleaseRow, course: &Course) -> Row {
    let told = [course.told(history), if row.is_flaky() { "flaky" } else { "" }.to_owned()];
    let told: Vec<String> = told.into_iter().filter(|told| !told.is_empty()).collect();
    let told = Cell { class: "told".to_owned(), ..told.join(", ").into() };
    let marks = row.cells.iter().enumerate().map(|(at, cell)| mark(cell, course.became_bad.contains(&at)));
    let first_bad = course.first_bad.map(|at| ("first-bad", history.name(at).to_owned()));
    Row {
        cells: [Cell::from(&*row.id)].into_iter().chain(marks).chain([told]).collect(),
        data: [("case", row.id.clone())].into_iter().chain(first_bad).collect(),
        ..Row::default()
    }
}

fn mark(cell: &history::Cell, is_turned: bool) -> Cell {
    let (kind, title) = cell.kind().map_or(("none", "did not run"), |kind| (kind.name(), kind.title()));
    let (turned, flaky) = (if is_turned { " turned" } else { "" }, if cell.flaky { ", flaky" } else { "" });
    Cell {
        class: format!("verdict {kind}{turned}"),
        title: format!("{title}{flaky}"),
        ..format!("{}{}", sign(cell.kind()), if cell.flaky { "~" } else { "" }).into()
    }
}

fn times() -> Block {
    Block::Markup(html! {
        label { "Case " select #case {} }
        div #plots {}
        noscript { p { "The plots need JavaScript, which runs in this page only." } }
    })
}

/// The durations of each case and its measured times in milliseconds, over the releases.
fn series(history: &History) -> Value {
    let of_case = |row: &ReleaseRow| {
        let mut names: Vec<&String> = row.cells.iter().flat_map(|cell| cell.times_ns.keys()).collect();
        names.sort_unstable();
        names.dedup();
        let milliseconds = |nanos: Option<u64>| nanos.map(|nanos| nanos as f64 / 1e6);
        let duration: Vec<_> = row.cells.iter().map(|cell| milliseconds(cell.duration_ns)).collect();
        let measured = names.into_iter().map(|name| {
            let values = row.cells.iter().map(|cell| milliseconds(cell.times_ns.get(name).copied()));
            serde_json::json!({ "name": name, "values": values.collect::<Vec<_>>() })
        });
        let measured: Vec<Value> = measured.collect();
        serde_json::json!({ "id": row.id, "duration": duration, "measured": measured })
    };
    serde_json::json!({
        "releases": history.releases.iter().map(|release| &release.name).collect::<Vec<_>>(),
        "cases": history.cases.iter().map(of_case).collect::<Vec<_>>(),
    })
}
