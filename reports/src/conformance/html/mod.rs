//! The result as one self-contained HTML page.
//!
//! Everything that a device can influence goes through [`printable`] and through maud, which escapes markup.

mod case;
mod delays;
mod failures;
mod timeline;

use super::dictionary::{REPAIR, left, rows, sentence};
use super::skipped::Skipped;
use super::{Run, name_in_family, outcome, symbol};
use crate::escape::printable;
use crate::page::{self, Page};
use crate::provenance;
use canvass_suite::comparison::Comparison;
use canvass_suite::foreign;
use canvass_suite::verdict::Kind;
use maud::{Markup, html};
use std::io::{self, Write};

const STYLE: &str = include_str!("../../../assets/conformance.css");
const SCRIPT: &str = include_str!("../../../assets/conformance.js");

/// Writes the page.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let [name, _, _] = &run.info.device.names;
    let name = printable(name.as_deref().unwrap_or("CANopen device"));
    let page = Page {
        title: &format!("{name}: conformance"),
        styles: &[STYLE],
        scripts: &[SCRIPT],
        header: head(run, &name),
        sections: &sections(run),
        footer: html! { "Times are those of the bus. A section that is not attested is marked." },
    };
    page::write(&page, out, |out| page::put(out, body(run)))
}

fn body(run: &Run) -> Markup {
    html! {
        section.tiles aria-label="Verdicts" { @for kind in Kind::ALL { (tile(run, kind)) } }
        (failures::section(run))
        section { h2 #matrix { "Matrix" } (matrix(run)) }
        (compared(run))
        (needed(run))
        section {
            h2 #cases { "Cases" }
            div.filter {
                input #filter type="search" placeholder="Filter by id, clause or text" aria-label="Filter";
                span #shown aria-live="polite" {}
            }
            @for report in failures::first(run) { (case::details(report)) }
        }
        (provenance::html(&run.provenance))
    }
}

fn sections(run: &Run) -> Vec<(&'static str, &'static str)> {
    let failed = failures::any(run).then_some(("failed", "Failed"));
    failed.into_iter().chain([("matrix", "Matrix"), ("cases", "Cases"), ("about", "About this report")]).collect()
}

fn head(run: &Run, name: &str) -> Markup {
    let info = &run.info;
    let good = run.summary.is_good() && run.comparison.as_ref().is_none_or(Comparison::is_as_found);
    let rate = info.bit_rate.map(|rate| format!(", {} kbit/s", rate / 1_000)).unwrap_or_default();
    let [_, hardware, software] = info.device.names.each_ref().map(|name| name.as_deref());
    let hex = |number: Option<u32>| number.map_or_else(|| "none".to_owned(), |number| format!("{number:08X}h"));
    let [vendor, product, revision, serial] = info.device.identity.map(hex);
    html! {
        p.kicker { "CANopen conformance" }
        h1 { (name) }
        p.outcome.(if good { "good" } else { "bad" }) {
            (outcome(&run.summary))
        }
        @for notice in &run.notices { p.note { (printable(notice)) } }
        dl.facts {
            (fact("Node", &info.node.to_string()))
            (fact("Bus", &format!("{}{rate}", info.bus)))
            @if !info.model.is_empty() { (fact("Description", &info.model)) }
            (fact("Hardware", hardware.unwrap_or("not given")))
            (fact("Software", software.unwrap_or("not given")))
            (fact("Device type", &hex(info.device.device_type)))
            (fact("Vendor-ID", &vendor))
            (fact("Product code", &product))
            (fact("Revision", &revision))
            (fact("Serial number", &serial))
            @if !run.other_clients.is_empty() { (fact("Other clients", &foreign::told(&run.other_clients))) }
            (fact("Duration", &run.summary.duration.to_string()))
        }
        @if let Some(host) = &run.summary.host { p.host { (super::host::sentence(host)) } }
    }
}

/// What a device or its description would have to have for the cases that did not apply.
fn needed(run: &Run) -> Markup {
    let skipped = Skipped::of(run);
    if skipped.is_empty() {
        return html! {};
    }
    html! {
        section {
            h2 { "What other cases would need" }
            ul {
                @for (reason, cases) in skipped.groups() {
                    li {
                        (printable(&reason)) ": "
                        @for (at, id) in cases.iter().enumerate() {
                            @if at > 0 { ", " }
                            a href={ "#" (id.replace('/', "-")) } { (id) }
                        }
                    }
                }
            }
        }
    }
}

fn compared(run: &Run) -> Markup {
    let Some(comparison) = &run.comparison else { return html! {} };
    html! {
        section {
            h2 { "Object dictionary before and after" }
            p.note[!comparison.is_as_found()] { (printable(&sentence(comparison))) }
            @if let Some(comparison) = left(run) {
                div.scroll {
                    table {
                        thead { tr { th { "Object" } th { "Name" } th { "Before" } th { "After" } } }
                        tbody {
                            @for row in rows(comparison) {
                                tr { @for cell in row { td { (printable(&cell)) } } }
                            }
                        }
                    }
                }
                @if !comparison.commands.is_empty() {
                    p { (REPAIR) }
                    @for command in &comparison.commands { p { code { (printable(command)) } } }
                }
            }
        }
    }
}

fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (printable(value)) } } }
}

fn tile(run: &Run, kind: Kind) -> Markup {
    let count = run.summary.count(kind);
    html! {
        button.tile.(kind.name()) type="button" data-kind=(kind.name()) aria-pressed="false" disabled[count == 0] {
            span.count { (count) }
            span.name { span aria-hidden="true" { (symbol(kind)) " " } (kind.title()) }
        }
    }
}

fn matrix(run: &Run) -> Markup {
    html! {
        div.matrix {
            @for (name, group) in run.families() {
                div.family { (name) }
                div.cells {
                    @for report in group {
                        @let kind = report.verdict.kind();
                        a.cell.(kind.name()) href={ "#" (case::anchor(report)) }
                            title={ (report.case.id) ": " (kind.title()) } {
                            span aria-hidden="true" { (symbol(kind)) } " " (name_in_family(report.case.id))
                        }
                    }
                }
            }
        }
    }
}
