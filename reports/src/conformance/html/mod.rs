//! The result as one self-contained HTML page.
//!
//! Everything that a device can influence goes through [`printable`] and through maud, which escapes markup.

mod case;

use super::{Run, name_in_family, outcome, symbol};
use crate::escape::printable;
use crate::page::{self, Page};
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
    out.write_all(page(run).into_string().as_bytes())?;
    out.write_all(b"\n")
}

fn page(run: &Run) -> Markup {
    let [name, _, _] = &run.info.device.names;
    let name = printable(name.as_deref().unwrap_or("CANopen device"));
    page::render(&Page {
        title: &format!("{name}: conformance"),
        styles: &[STYLE],
        scripts: &[SCRIPT],
        header: head(run, &name),
        sections: &[],
        main: body(run),
        footer: html! { "Times are those of the bus. A section that is not attested is marked." },
    })
}

fn body(run: &Run) -> Markup {
    html! {
        section.tiles aria-label="Verdicts" { @for kind in Kind::ALL { (tile(run, kind)) } }
        section { h2 { "Matrix" } (matrix(run)) }
        section {
            h2 { "Cases" }
            div.filter {
                input #filter type="search" placeholder="Filter by id, clause or text" aria-label="Filter";
                span #shown aria-live="polite" {}
            }
            @for report in &run.cases { (case::details(report)) }
        }
    }
}

fn head(run: &Run, name: &str) -> Markup {
    let info = &run.info;
    let good = run.summary.is_good();
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
            (fact("Duration", &run.summary.duration.to_string()))
        }
        @if let Some(host) = &run.summary.host { p.host { (super::host::sentence(host)) } }
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
            @for group in run.cases.chunk_by(|a, b| a.case.family() == b.case.family()) {
                @let name = group.first().map_or("", |report| report.case.family());
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
