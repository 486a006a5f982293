//! The figures of each node.

use super::{lane, text};
use crate::diagnosis::Diagnosed;
use crate::diagnosis::node_table::{profile, rounded, rows as overview, who};
use crate::page::put;
use crate::page_text::capitalised;
use crate::provenance::{identity_facts, identity_of};
use canvass_analyzer::dictionary::names::ErrorName;
use canvass_analyzer::statistics::{BusStatistics, Histogram, NodeStatistics, TestRun};
use canvass_analyzer::{NodeId, Service};
use canvass_traces::{ChannelId, Duration};
use maud::{Markup, PreEscaped, html};
use std::io::{self, Write};

/// Maximum number of listed state changes of a node.
const STATES: usize = 40;
/// Maximum number of listed cases of CiA's test tool.
const CASES: usize = 500;

/// Writes a table of all nodes, then each node in full. It writes piece by piece, as there may be thousands of nodes on
/// many channels.
///
/// # Errors
/// The errors of `out`.
pub fn write(diagnosed: &Diagnosed<'_>, out: &mut dyn Write) -> io::Result<()> {
    put(out, html! { (PreEscaped("<section aria-labelledby=\"nodes\">")) h2 #nodes { "Nodes" } })?;
    match overview(diagnosed, true).split_first() {
        Some((head, rows)) => put(out, table(head, rows))?,
        None => put(out, html! { p.hint { "No node sent anything or was addressed." } })?,
    }
    for (channel, bus) in &diagnosed.results.buses {
        for (id, node) in bus.nodes.iter().filter(|(_, node)| node.total() > 0) {
            put(out, of_node(diagnosed, (*channel, bus), *id, node))?;
        }
    }
    for (_, bus) in &diagnosed.results.buses {
        put(out, test_run(diagnosed, &bus.test_run))?;
    }
    put(out, PreEscaped("</section>".to_owned()))
}

fn table(head: &[String], rows: &[Vec<String>]) -> Markup {
    html! {
        div.card.scroll {
            table.nodes {
                caption.unseen { "All nodes" }
                thead { tr { @for cell in head { th scope="col" { (cell) } } } }
                tbody { @for row in rows { tr { @for cell in row { td { (cell) } } } } }
            }
        }
    }
}

fn of_node(
    diagnosed: &Diagnosed<'_>,
    (channel, bus): (ChannelId, &BusStatistics),
    id: NodeId,
    node: &NodeStatistics,
) -> Markup {
    let seconds = bus.duration().nanos() as f64 / 1e9;
    let rate = if seconds > 0.0 { format!(", {:.1} frames/s", node.total() as f64 / seconds) } else { String::new() };
    let all: u64 = bus.bits.iter().sum();
    let share = node.bits as f64 * 100.0 / all.max(1) as f64;
    let name = text(&who(node));
    html! {
        details.node.card {
            summary {
                strong { "Node " (id) }
                @if diagnosed.results.buses.len() > 1 { " on " (text(&diagnosed.channel(channel))) }
                span.who { (name) }
            }
            div.body {
                p {
                    (node.total()) " frames" (rate) ", " (format!("{share:.1}")) " % of all bits, from "
                    (diagnosed.since_start(node.first)) " to " (diagnosed.since_start(node.last)) " s."
                    @if let Some(load) = bus.mean_load() { " Load of its own: " (format!("{:.1}", load * share / 100.0)) " %." }
                }
                div.columns {
                    (identity(node))
                    (services(node))
                    (responses(node))
                    (emcy(diagnosed, node))
                    (states(diagnosed, node))
                }
            }
        }
    }
}

fn identity(node: &NodeStatistics) -> Markup {
    let rows = identity_facts(&identity_of(&node.identity));
    html! {
        @if rows.iter().any(|row| row.1.is_some()) {
            table {
                caption { "Identity, as read" }
                @for (label, value) in rows.iter().filter_map(|(label, value)| Some((label, value.as_ref()?))) {
                    tr { th scope="row" { (capitalised(label)) } td.text { (text(value)) } }
                }
            }
        }
    }
}

fn services(node: &NodeStatistics) -> Markup {
    let rows: Vec<_> = Service::ALL.into_iter().zip(node.frames).filter(|(_, count)| *count > 0).collect();
    let most = rows.iter().map(|row| row.1).max().unwrap_or(1);
    html! {
        table {
            caption { "Frames by service" }
            @for (service, count) in rows {
                tr {
                    th scope="row" { (service) }
                    td.number { (count) }
                    td { svg.share viewBox="0 0 100 8" aria-hidden="true" preserveAspectRatio="none" {
                        rect.bar width=(format!("{:.1}", count as f64 * 100.0 / most as f64)) height="8" rx="2" {}
                    } }
                }
            }
        }
    }
}

fn responses(node: &NodeStatistics) -> Markup {
    let times: &Histogram = &node.responses;
    let shown = |time: Option<Duration>| time.map(|time| rounded(time).to_string()).unwrap_or_default();
    html! {
        @if times.count() > 0 {
            table {
                caption { "SDO" }
                tr { th scope="row" { "completed" } td.number { (node.completed) } }
                tr { th scope="row" { "aborted" } td.number { (node.aborted) } }
                tr { th scope="row" { "shortest response" } td.number { (shown(times.min())) } }
                @for percent in [50, 95, 99] {
                    tr { th scope="row" { "p" (percent) } td.number { (shown(times.quantile(percent))) } }
                }
                tr { th scope="row" { "longest response" } td.number { (shown(times.max())) } }
            }
        }
    }
}

fn emcy(diagnosed: &Diagnosed<'_>, node: &NodeStatistics) -> Markup {
    html! {
        @if !node.emcy.is_empty() {
            table {
                caption { "EMCY" }
                thead { tr { th scope="col" { "Code" } th.number scope="col" { "Count" } th.number scope="col" { "First [s]" } th.number scope="col" { "Last [s]" } } }
                @for row in &node.emcy {
                    tr {
                        td.text { (ErrorName { code: row.code, profile: profile(node) }) }
                        td.number { (row.count) }
                        td.number { (diagnosed.since_start(row.first)) }
                        td.number { (diagnosed.since_start(row.last)) }
                    }
                }
            }
        }
    }
}

fn states(diagnosed: &Diagnosed<'_>, node: &NodeStatistics) -> Markup {
    let more = node.states.len().saturating_sub(STATES) as u64 + node.states_omitted;
    html! {
        @if !node.states.is_empty() {
            table {
                caption { "NMT states (" (node.boot_ups) " boot-ups)" }
                thead { tr { th.number scope="col" { "From [s]" } th scope="col" { "State" } th scope="col" { "Known from" } } }
                @for change in node.states.iter().take(STATES) {
                    tr {
                        td.number { (diagnosed.since_start(change.time)) }
                        td { (lane::name(change)) }
                        td { (change.cause.name()) }
                    }
                }
                @if more > 0 { tr { td.gap colspan="3" { (more) " more" } } }
            }
        }
    }
}

/// The cases of a conformance test whose marks were found in the capture.
fn test_run(diagnosed: &Diagnosed<'_>, run: &TestRun) -> Markup {
    let all = run.cases.len() as u64 + run.omitted;
    html! {
        @if !run.cases.is_empty() {
            details.card.node open {
                summary { strong { "Test run" } span.who { (all) " cases" } }
                div.body.scroll {
                    table {
                        thead { tr {
                            th scope="col" { "Case" } th scope="col" { "Verdict" }
                            th.number scope="col" { "From [s]" } th.number scope="col" { "To [s]" } th.number scope="col" { "Frames" }
                        } }
                        @for case in run.cases.iter().take(CASES) {
                            tr {
                                td { (case.name) }
                                td { (case.verdict.as_deref().unwrap_or("not ended")) }
                                td.number { (diagnosed.since_start(case.begin)) }
                                td.number { (diagnosed.since_start(case.end)) }
                                td.number { (case.frames) }
                            }
                        }
                    }
                    @if all > CASES as u64 { p.hint { (all - CASES as u64) " more: canvass diagnose --format json has all." } }
                }
            }
        }
    }
}
