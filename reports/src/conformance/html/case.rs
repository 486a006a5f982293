//! One case on the page.

use super::{delays, timeline};
use crate::conformance::told::Told;
use crate::conformance::{cct_forecast, hex, milliseconds_since, quarantined, recorded, repetitions, symbol, uses};
use crate::escape::printable;
use canvass_suite::bench::Exhibit;
use canvass_suite::runner::CaseReport;
use canvass_suite::verdict::Kind;
use canvass_traces::{Direction, Timestamp};
use maud::{Markup, html};

/// The name of the case as a place on the page.
pub fn anchor(report: &CaseReport) -> String {
    report.case.id.replace('/', "-")
}

/// A case: its summary, and when opened everything about it.
pub fn details(report: &CaseReport) -> Markup {
    let kind = report.verdict.kind();
    let open = matches!(kind, Kind::Fail | Kind::Error);
    html! {
        details.case id=(anchor(report)) data-kind=(kind.name()) open[open] {
            summary {
                span.badge.(kind.name()) { span aria-hidden="true" { (symbol(kind)) " " } (kind.title()) }
                span.id { (report.case.id) }
                span.clause { (report.case.clause.to_string()) }
            }
            div.body {
                @for paragraph in report.case.requirement.split("\n\n") { p.requirement { (printable(paragraph)) } }
                (reason(report))
                @if let Some(quarantined) = quarantined(report) { p.note { "Does not count: " (quarantined) } }
                @if let Some(repetitions) = repetitions(report) { p.note { (repetitions) } }
                @if let Some(uses) = uses(report) { p.meta { "Used: " (uses) } }
                @for measurement in &report.measurements { p.measurement { (printable(&measurement.to_string())) } }
                @for note in &report.notes { p.note { (printable(note)) } }
                p.meta {
                    "Level: " (report.case.level.name())
                    @if let Some(cct) = report.case.cct { " · comparable with case " (cct) " of CiA’s test tool" }
                    @if let Some(forecast) = cct_forecast(report) { ", which would " (forecast) }
                    " · " (report.duration) " on the bus"
                }
                (evidence(report))
            }
        }
    }
}

fn reason(report: &CaseReport) -> Markup {
    html! {
        @for told in Told::all(report) {
            dl.reason {
                dt { "Duty" } dd { (printable(&told.duty)) }
                dt { "Expected" } dd { (printable(&told.expected)) }
                dt { "Found" } dd.actual { (printable(&told.found)) }
                @if let Some(excuse) = &told.excuse {
                    dt { (told.authority()) } dd { (printable(&excuse.documented)) }
                }
                @if let Some(waiver) = told.waiver() {
                    dt { "As data" } dd { code { (printable(&waiver)) } }
                }
            }
        }
    }
}

fn evidence(report: &CaseReport) -> Markup {
    let frames: Vec<&Exhibit> = report.evidence.frames().collect();
    let Some(start) = frames.first().map(|first| first.record.timestamp) else { return html! {} };
    let (omitted, is_recorded) = (report.evidence.omitted(), recorded(report).is_some());
    html! {
        details.evidence open[matches!(report.verdict.kind(), Kind::Fail | Kind::Error)] {
            summary {
                (frames.len()) " frames" @if omitted > 0 { " (" (omitted) " more left out)" }
                @if let Some([first, last]) = recorded(report) { ": #" (first) " to #" (last) " of the recording" }
            }
            (timeline::strip(&frames))
            (delays::plot(&frames))
            div.scroll {
                table {
                    thead { tr { @if is_recorded { th.number { "#" } } th.number { "ms" } th { "" } th { "CAN-ID" } th { "Data" } th { "Meaning" } } }
                    tbody {
                        @for (at, exhibit) in frames.iter().enumerate() {
                            @if omitted > 0 && at == report.evidence.gap() {
                                tr { td.gap colspan=(5 + usize::from(is_recorded)) { (omitted) " frames left out" } }
                            }
                            (row(exhibit, start))
                        }
                    }
                }
            }
        }
    }
}

fn row(exhibit: &Exhibit, start: Timestamp) -> Markup {
    let record = &exhibit.record;
    let number = record.place.number;
    let sent = record.direction == Direction::Tx;
    html! {
        tr.sent[sent] id=[(number > 0).then(|| format!("frame-{number}"))] {
            @if number > 0 { td.number { a href={ "#frame-" (number) } { (number) } } }
            td.number { (milliseconds_since(start, record)) }
            td title=(if sent { "sent by the tester" } else { "received" }) { (if sent { "→" } else { "←" }) }
            td { (record.frame.id()) }
            td { (hex(record)) }
            td.text { (printable(&exhibit.text)) }
        }
    }
}
