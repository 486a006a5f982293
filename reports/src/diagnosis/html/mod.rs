//! The diagnosis as one self-contained HTML page.
//!
//! The page contains a summary of the captures. Findings with their evidence and figures are markup. Frames and values
//! over time are data for our own scripts, which show it as text and lines and never as markup.

mod collector;
mod data;
mod excerpt;
mod findings;
mod histogram;
mod lane;
mod nodes;
mod summary;

pub use collector::Collector;

use super::Diagnosed;
use crate::document::{self, Depth};
use crate::escape::printable;
use crate::page::{self, Page};
use excerpt::Shown;
use maud::{Markup, html};
use std::io::{self, Write};

const STYLES: [&str; 2] =
    [include_str!("../../../assets/uplot/uPlot.min.css"), include_str!("../../../assets/diagnosis.css")];
const SCRIPTS: [&str; 8] = [
    include_str!("../../../assets/uplot/uPlot.iife.min.js"),
    include_str!("../../../assets/diagnosis/data.js"),
    include_str!("../../../assets/diagnosis/view.js"),
    include_str!("../../../assets/diagnosis/plots.js"),
    include_str!("../../../assets/diagnosis/timeline.js"),
    include_str!("../../../assets/diagnosis/frames.js"),
    include_str!("../../../assets/diagnosis/findings.js"),
    include_str!("../../../assets/diagnosis/linked.js"),
];

const SECTIONS: [(&str, &str); 9] = [
    ("summary", "Summary"),
    ("timeline", "Timeline"),
    ("load", "Bus load"),
    ("signals", "Signals"),
    ("responses", "SDO responses"),
    ("nodes", "Nodes"),
    ("findings", "Findings"),
    ("frames", "Frames"),
    ("about", "About this report"),
];

/// Maximum number of shown findings. Nobody reads more.
const MOST_FINDINGS: usize = 1000;

/// Writes the page.
///
/// # Errors
/// The errors of `out`.
pub fn render(diagnosed: &Diagnosed<'_>, mut collected: Collector, out: &mut dyn Write) -> io::Result<()> {
    let seen = collected.excerpt.seen();
    let evidence = diagnosed.results.findings.iter().take(MOST_FINDINGS).flat_map(|finding| &finding.evidence);
    let frames = std::mem::take(&mut collected.excerpt).finish(evidence);
    let places = excerpt::places(&frames);
    let name = summary::names(diagnosed);
    let page = Page {
        title: &format!("{name}: diagnosis"),
        styles: &STYLES,
        scripts: &SCRIPTS,
        header: summary::head(diagnosed, &name),
        sections: &SECTIONS,
        footer: html! { "Times count from the first frame. " (page::plot_licence()) },
    };
    page::write(&page, out, |out| {
        page::put(out, summary::section(diagnosed))?;
        page::put(out, timeline())?;
        page::put(out, load(diagnosed))?;
        page::put(out, signals(&collected))?;
        page::put(out, histogram::section(diagnosed))?;
        nodes::write(diagnosed, out)?;
        page::put(out, findings::section(diagnosed, &places))?;
        page::put(out, frame_list(&frames, seen))?;
        page::put(out, document::html::section(&diagnosed.provenance.section(Depth::Page, true)))?;
        page::put_data(out, "data", &data::Data::new(diagnosed, &collected, &frames, &places))
    })
}

/// The controls above a plot over time. All plots show the same time.
fn controls(what: &str) -> Markup {
    html! {
        div.controls role="group" aria-label={ "Time shown in " (what) } {
            button.plain type="button" data-view="back" title="Earlier" { span aria-hidden="true" { "◀" } span.unseen { "Earlier" } }
            button.plain type="button" data-view="in" title="Shorter time" { span aria-hidden="true" { "+" } span.unseen { "Zoom in" } }
            button.plain type="button" data-view="out" title="Longer time" { span aria-hidden="true" { "−" } span.unseen { "Zoom out" } }
            button.plain type="button" data-view="on" title="Later" { span aria-hidden="true" { "▶" } span.unseen { "Later" } }
            button.plain type="button" data-view="all" { "Whole capture" }
            span.range {}
        }
    }
}

fn timeline() -> Markup {
    html! {
        section aria-labelledby="timeline" {
            div.head { h2 #timeline { "Timeline" } (controls("timeline and plots")) }
            p.hint {
                "NMT states of each node. Drag to zoom, drag with Shift to move, double-click to see all, click to mark a \
                 time here and in the plots; in a focused plot the arrow keys move, + and − zoom, 0 shows all."
            }
            ul.legend #states {}
            div.card.lanes #lanes {}
            noscript { p { "Timeline, plots and frame list need JavaScript, which runs in this page only." } }
        }
    }
}

fn load(diagnosed: &Diagnosed<'_>) -> Markup {
    let guessed = diagnosed.results.buses.iter().any(|(_, bus)| bus.bit_rate.is_none());
    html! {
        section aria-labelledby="load" {
            div.head { h2 #load { "Bus load" } (controls("timeline and plots")) }
            p.hint {
                "Frames with their stuff bits. The band reaches from the emptiest to the fullest tenth of a second."
                @if guessed { " Where the bit rate is not known, kbit/s are shown." }
            }
            div #load-plots {}
        }
    }
}

fn signals(collected: &Collector) -> Markup {
    let columns = collected.sampler.columns();
    let (shown, all) = (columns.len().min(crate::signals::Series::MOST), columns.len() as u64 + columns.left_out);
    html! {
        section aria-labelledby="signals" {
            div.head { h2 #signals { "Signals" } (controls("timeline and plots")) }
            @if columns.is_empty() {
                p.hint {
                    "No PDO whose mapping is known. It is known from the SDO traffic of a capture that shows how it is \
                     read or written, or from the description of the node's device, where one is given."
                }
            } @else {
                p.hint {
                    "Values of PDOs. Long captures are thinned out, and keep the least and the greatest of each time."
                    @if all > shown as u64 { " " (shown) " of them are shown; canvass signals prints all." }
                }
                fieldset.chips #signal-choice { legend.unseen { "Signals to show" } }
                div #signal-plots {}
            }
        }
    }
}

fn frame_list(frames: &[Shown], seen: u64) -> Markup {
    html! {
        section aria-labelledby="frames" {
            h2 #frames { "Frames" }
            p.hint {
                @if frames.len() as u64 >= seen { "All " (seen) " frames of the capture." } @else {
                    (frames.len()) " of " (seen) " frames: those around findings, the first and the last ones. \
                    canvass decode shows all."
                }
            }
            div.filter role="search" aria-label="Frames" {
                input #frame-text type="search" placeholder="Filter by id, data or meaning" aria-label="Filter by CAN-ID, data or meaning";
                label { "Service " select #frame-service { option value="" { "all" } } }
                label { "Node " select #frame-node { option value="" { "all" } } }
                label { input #frame-proof type="checkbox"; " only evidence" }
                label { input #frame-view type="checkbox"; " only the time shown above" }
                span #frames-shown role="status" {}
            }
            div.card.scroll {
                table.frames {
                    caption.unseen { "Frames with what they mean and the findings that they prove" }
                    thead { tr {
                        th.number scope="col" { "Time [s]" } th.number scope="col" { "Line" }
                        th scope="col" { "Channel" } th scope="col" { "Node" } th scope="col" { "Service" }
                        th scope="col" { "CAN-ID" } th scope="col" { "Data" } th scope="col" { "Meaning" }
                    } }
                    tbody #frame-rows {}
                }
            }
            div.pager {
                button.plain #frames-back type="button" { "◀ Earlier" }
                span #frames-page {}
                button.plain #frames-on type="button" { "Later ▶" }
            }
        }
    }
}

/// The link to a position in the list of frames.
fn frame_link(at: usize) -> String {
    format!("#frame-{at}")
}

/// A text that is safe to show.
fn text(value: &str) -> String {
    printable(value).into_owned()
}
