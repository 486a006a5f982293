//! The history as one self-contained page: the matrix of cases and releases, and times over the releases.

use super::{Course, History, ReleaseRow, sign};
use crate::escape::printable;
use crate::page::{self, Page};
use crate::provenance;
use crate::results::history::Cell;
use maud::{Markup, html};
use serde_json::{Value, json};
use std::io::{self, Write};

const STYLES: [&str; 2] = [include_str!("../../assets/uplot/uPlot.min.css"), include_str!("../../assets/history.css")];
const SCRIPTS: [&str; 2] =
    [include_str!("../../assets/uplot/uPlot.iife.min.js"), include_str!("../../assets/history.js")];
const UPLOT_LICENSE: &str = include_str!("../../assets/uplot/LICENSE");

/// Writes the page.
///
/// # Errors
/// What `out` gives.
pub fn render(history: &History, out: &mut dyn Write) -> io::Result<()> {
    let sections =
        [("changed", "What changed"), ("matrix", "All cases"), ("times", "Times"), ("about", "About this report")];
    let main = html! {
        section { h2 #changed { "What changed" } (matrix(history, history.telling().collect())) }
        section {
            h2 #matrix { "All cases" }
            details { summary { (history.cases.len()) " cases" }
                (matrix(history, history.cases.iter().map(|row| (row, row.course())).collect()))
            }
        }
        (times())
        (provenance::html(&history.provenance))
    };
    let page = Page {
        title: "History",
        styles: &STYLES,
        scripts: &SCRIPTS,
        header: html! {
            p.kicker { "CANopen conformance" }
            h1 { "History" }
            p.outcome { (history.outcome()) }
        },
        sections: &sections,
        footer: html! {
            "Releases stand in the order in which they were given. "
            details { summary { "Plots are drawn by µPlot, under this licence" } pre { (UPLOT_LICENSE) } }
        },
    };
    page::write(&page, out, |out| {
        page::put(out, main)?;
        page::put_data(out, "data", &series(history))
    })
}

fn matrix(history: &History, rows: Vec<(&ReleaseRow, Course)>) -> Markup {
    html! {
        @if rows.is_empty() { p { "Nothing." } } @else {
            div.card.scroll { table.history {
                thead { tr {
                    th scope="col" { "Case" }
                    @for release in &history.releases {
                        th scope="col" title=(printable(&release.software.join(", "))) { (printable(&release.name)) }
                    }
                    th scope="col" { "" }
                } }
                tbody { @for (row, course) in rows { (line(history, row, &course)) } }
            } }
        }
    }
}

fn line(history: &History, row: &ReleaseRow, course: &Course) -> Markup {
    let first_bad = course.first_bad.map(|at| printable(history.name(at)).into_owned());
    html! {
        tr data-case=(printable(&row.id)) data-first-bad=[first_bad] {
            th scope="row" { (printable(&row.id)) }
            @for (at, cell) in row.cells.iter().enumerate() { (mark(cell, course.became_bad.contains(&at))) }
            td.told {
                (printable(&course.told(history)))
                @if row.is_flaky() { " flaky" }
            }
        }
    }
}

fn mark(cell: &Cell, turned: bool) -> Markup {
    let (kind, title) = cell.kind().map_or(("none", "did not run"), |kind| (kind.name(), kind.title()));
    html! {
        td.verdict.(kind).turned[turned] title=(title) {
            span aria-hidden="true" { (sign(cell.kind())) }
            span.unseen { (title) }
            @if cell.flaky { span.flaky title="flaky" { "~" } }
        }
    }
}

fn times() -> Markup {
    html! {
        section {
            h2 #times { "Times" }
            label { "Case " select #case {} }
            div #plots {}
            noscript { p { "The plots need JavaScript, which runs in this page only." } }
        }
    }
}

/// Milliseconds over the releases: of each case its duration, and each time that was measured in it.
fn series(history: &History) -> Value {
    let of_case = |row: &ReleaseRow| {
        let mut names: Vec<&String> = row.cells.iter().flat_map(|cell| cell.times_ns.keys()).collect();
        names.sort_unstable();
        names.dedup();
        let milliseconds = |nanos: Option<u64>| nanos.map(|nanos| nanos as f64 / 1e6);
        let duration: Vec<_> = row.cells.iter().map(|cell| milliseconds(cell.duration_ns)).collect();
        let measured = names.into_iter().map(|name| {
            let values = row.cells.iter().map(|cell| milliseconds(cell.times_ns.get(name).copied()));
            json!({ "name": name, "values": values.collect::<Vec<_>>() })
        });
        let measured: Vec<Value> = measured.collect();
        json!({ "id": row.id, "duration": duration, "measured": measured })
    };
    json!({
        "releases": history.releases.iter().map(|release| &release.name).collect::<Vec<_>>(),
        "cases": history.cases.iter().map(of_case).collect::<Vec<_>>(),
    })
}
