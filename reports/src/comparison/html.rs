//! The differences as one self-contained HTML page.

use super::{Comparison, Direction};
use crate::escape::printable;
use crate::page::{self, Page};
use crate::provenance;
use crate::results::compare::Change;
use maud::{Markup, html};
use std::io::{self, Write};

/// Writes the page.
///
/// # Errors
/// What `out` gives.
pub fn render(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let present = Direction::ALL.into_iter().filter(|direction| comparison.of(*direction).next().is_some());
    let present: Vec<Direction> = present.collect();
    let sections: Vec<(&str, &str)> = present
        .iter()
        .map(|direction| (direction.name(), direction.title()))
        .chain([("about", "About this report")])
        .collect();
    let class = if comparison.has_regressions() { "bad" } else { "good" };
    let page = Page {
        title: "What the release changed",
        styles: &[],
        scripts: &[],
        header: html! {
            p.kicker { "CANopen conformance" }
            h1 { "What the release changed" }
            p.outcome.(class) { (comparison.outcome()) }
        },
        sections: &sections,
        footer: html! { "What changed for the worse comes first." },
    };
    let main = html! {
        @for direction in &present { (section(comparison, *direction)) }
        (provenance::html(&comparison.provenance))
    };
    page::write(&page, out, |out| page::put(out, main))
}

fn section(comparison: &Comparison, direction: Direction) -> Markup {
    html! {
        section {
            h2 id=(direction.name()) { (direction.title()) }
            div.card.scroll { table {
                thead { tr { th { "" } th { "Subject" } th { "Before" } th { "Now" } th { "Why" } } }
                tbody { @for change in comparison.of(direction) { (row(change)) } }
            } }
        }
    }
}

fn row(change: &Change) -> Markup {
    let (old, new) = change.values();
    html! {
        tr {
            td { (change.kind) }
            td { (printable(&change.subject)) }
            td { (printable(old)) }
            td { (printable(new)) }
            td { (printable(&change.why().unwrap_or_default())) }
        }
    }
}
