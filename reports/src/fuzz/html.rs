//! The result as one self-contained HTML page.

use super::{Run, Words, annotated, left, outcome, reliability, rust_test, sdo_rows, trouble};
use crate::escape::printable;
use crate::page::{self, Page};
use crate::provenance;
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::reproducer;
use canvass_traces::{Direction, Timestamp};
use maud::{Markup, html};
use std::io::{self, Write};

const STYLE: &str = include_str!("../../assets/fuzz.css");

/// Writes the page.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let sections = [("violations", "Violations"), ("coverage", "Coverage"), ("about", "About this report")];
    let page = Page {
        title: &format!("Fuzzing of node {}", run.node),
        styles: &[STYLE],
        scripts: &[],
        header: head(run),
        sections: &sections,
        footer: html! { "Times are those of the bus." },
    };
    let main = html! {
        section #violations { h2 { "Violations" }
            @if run.outcome.violations.is_empty() { p { "None." } }
            @for (found, words) in run.violations() { (violation(run, found, words)) }
        }
        section #coverage { h2 { "Coverage" } (coverage(run)) }
        (provenance::html(&run.provenance))
    };
    page::write(&page, out, |out| page::put(out, main))
}

fn head(run: &Run) -> Markup {
    let good = run.outcome.violations.is_empty() && run.outcome.ended_by.is_none();
    let fact = |name: &str, value: &str| html! { div { dt { (name) } dd { (printable(value)) } } };
    html! {
        p.kicker { "CANopen fuzzing" }
        h1 { "Node " (run.node) @if !run.model.is_empty() { ": " (printable(&run.model)) } }
        p.outcome.(if good { "good" } else { "bad" }) { (outcome(run)) }
        dl.facts {
            (fact("Bus", &run.bus))
            (fact("Target", &run.targets.to_string()))
            (fact("Never done, as not allowed", &run.forbidden()))
            (fact("Seed", &run.seed.to_string()))
            (fact("Exchanges", &run.outcome.executions.to_string()))
            (fact("Frames sent", &run.outcome.frames.to_string()))
            (fact("Sequences", &run.outcome.sequences.to_string()))
            (fact("SDO, state × command", &run.sdo_share().to_string()))
            (fact("LSS, state × command", &run.lss_share().to_string()))
            @let trouble = trouble(run);
            @if !trouble.is_empty() { (fact("The bus", &trouble)) }
            @let left = left(run);
            @if !left.is_empty() { (fact("At the end", &left)) }
            (fact("Repeat with", &run.repeat))
        }
    }
}

fn violation(run: &Run, found: &Found, words: &Words) -> Markup {
    let violation = &found.violation;
    let start = found.evidence.first().map_or(Timestamp::ZERO, |record| record.timestamp);
    let block = |title: &str, text: &str| {
        let lines: Vec<_> = text.lines().map(printable).collect();
        html! { details { summary { (title) } pre { (lines.join("\n")) } } }
    };
    html! {
        article.card.violation {
            h3 { (violation.property.id()) ": " (violation.rule) }
            p { (violation.property.title()) }
            dl.reason {
                dt { "Expected" } dd { (printable(&violation.expected)) }
                dt { "Found" } dd.actual { (printable(&violation.actual)) }
                dt { "It" } dd { (reliability(found, run.outcome.dead)) }
            }
            pre { @for line in annotated(found, words).lines() { (printable(line)) "\n" } }
            details {
                summary { "All frames on the bus (" (found.evidence.len()) ")" }
                div.wide { table {
                    thead { tr { th { "ms" } th { "" } th { "frame" } th { "meaning" } } }
                    tbody { @for (record, words) in found.evidence.iter().zip(&words.evidence) {
                        tr {
                            td { (milliseconds(record.timestamp.since(start).nanos())) }
                            td { (if record.direction == Direction::Tx { "tx" } else { "rx" }) }
                            td { code { (record.frame) } }
                            td { (printable(words)) }
                        }
                    } }
                } }
            }
            (block("Log for canplayer and canvass fuzz --replay", &reproducer::candump(&found.sequence)))
            (block("Rust test", &rust_test(run, found)))
        }
    }
}

fn milliseconds(nanos: u64) -> String {
    format!("{}.{:03}", nanos / 1_000_000, nanos / 1_000 % 1_000)
}

fn coverage(run: &Run) -> Markup {
    html! {
        div.wide { table {
            thead { tr { th { "SDO state" } th { "command" } th { "answers" } } }
            tbody { @for (state, command, answers) in sdo_rows(run) {
                tr {
                    td { (state) } td { (command) }
                    td { @for (n, (answer, count)) in answers.iter().enumerate() {
                        @if n > 0 { ", " } (answer.name()) " " (count)
                    } }
                }
            } }
        } }
        div.wide { table {
            thead { tr { th { "LSS state" } th { "command" } th { "answered" } th { "times" } } }
            tbody { @for (state, command, answered, count) in run.coverage().lss_rows() {
                tr {
                    td { (state.name()) } td { (command.name()) } td { (if answered { "yes" } else { "no" }) }
                    td { (count) }
                }
            } }
        } }
    }
}
