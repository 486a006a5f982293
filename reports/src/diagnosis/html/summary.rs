//! The summary of a page: the captures, and the worst findings.

use super::{MOST_FINDINGS, findings, text};
use crate::diagnosis::Diagnosed;
use crate::diagnosis::node_table::rounded;
use crate::diagnosis::report;
use crate::page::fact;
use crate::page_text::counted;
use canvass_analyzer::findings::Severity;
use canvass_analyzer::statistics::BusStatistics;
use canvass_traces::TimeBase;
use maud::{Markup, html};

/// Maximum number of findings in the summary.
const FOREMOST: usize = 12;

/// The names of the captures, or their number.
pub fn names(diagnosed: &Diagnosed<'_>) -> String {
    match diagnosed.captures {
        [] => "capture".to_owned(),
        [one] if one.name == "-" => "standard input".to_owned(),
        [one] => text(one.name.rsplit(['/', '\\']).next().unwrap_or(one.name)),
        [first, rest @ ..] => format!("{} and {} more", text(first.name), rest.len()),
    }
}

/// The head of the page.
pub fn head(diagnosed: &Diagnosed<'_>, name: &str) -> Markup {
    let [errors, warnings] = [Severity::Error, Severity::Warning].map(|severity| diagnosed.count(severity));
    let (class, outcome) = match (errors, warnings) {
        (0, 0) => ("good", "Nothing wrong was found".to_owned()),
        (0, n) => ("doubt", format!("No error, {}", counted(n, "warning"))),
        (n, 0) => ("bad", counted(n, "error")),
        (n, m) => ("bad", format!("{}, {}", counted(n, "error"), counted(m, "warning"))),
    };
    html! {
        p.kicker { "CANopen diagnosis" }
        h1 { (name) }
        p.outcome.(class) { (outcome) }
    }
}

/// The figures of the buses, the findings by severity, and the worst of the findings.
pub fn section(diagnosed: &Diagnosed<'_>) -> Markup {
    let found = &diagnosed.results.findings;
    html! {
        section aria-labelledby="summary" {
            h2.unseen #summary { "Summary" }
            @for (id, bus) in &diagnosed.results.buses {
                @let name = text(&diagnosed.channel(*id));
                dl.facts.card.bus { (facts(diagnosed, &name, bus)) }
            }
            @if let Some(left_out) = report::left_out(diagnosed) {
                p.hint { "Left out: " (left_out) "." }
            }
            @if diagnosed.results.unwatched > 0 {
                p.hint { (diagnosed.results.unwatched) " frames of further channels were not looked at." }
            }
            (captures(diagnosed))
            div.tiles role="group" aria-label="Findings by severity" {
                @for severity in [Severity::Error, Severity::Warning, Severity::Info] { (tile(diagnosed, severity)) }
            }
            @if !found.is_empty() {
                ol.foremost {
                    @for (at, finding) in findings::heads(diagnosed).take(FOREMOST) {
                        li.(finding.severity.name()) {
                            a href={ "#" (findings::anchor(at)) } {
                                (findings::badge(finding.severity, 1))
                                span.title { (finding.rule.title) }
                                span.message { (text(&finding.message)) }
                            }
                            span.whom { (text(&diagnosed.whom(finding))) }
                            span.when { (diagnosed.since_start(finding.first)) " s" }
                        }
                    }
                }
                @if found.len() > diagnosed.results.stories.len().min(FOREMOST) {
                    p.hint { a href="#findings" { "All " (found.len().min(MOST_FINDINGS)) " findings" } }
                }
            }
        }
    }
}

fn facts(diagnosed: &Diagnosed<'_>, name: &str, bus: &BusStatistics) -> Markup {
    let present: Vec<String> =
        bus.nodes.iter().filter(|(_, node)| node.present).map(|(id, _)| id.to_string()).collect();
    let nodes = if present.is_empty() { "none sent anything".to_owned() } else { present.join(", ") };
    let rate = bus.bit_rate_text().unwrap_or_else(|| "not known".to_owned());
    let utc = diagnosed.captures.iter().all(|capture| capture.time_base == TimeBase::Utc);
    html! {
        (fact("Channel", name))
        (fact("Frames", &bus.total().to_string()))
        (fact("Duration", &rounded(bus.duration()).to_string()))
        @if utc { (fact("Begin (UTC)", &date(bus))) }
        (fact("Nodes", &nodes))
        (fact("Bit rate", &rate))
        @if let (Some(mean), Some((at, peak))) = (bus.mean_load(), bus.peak_load()) {
            (fact("Mean load", &format!("{mean:.1} %")))
            (fact("Peak load", &format!("{peak:.1} % at {:.1} s", at.since(bus.first).nanos() as f64 / 1e9)))
        }
    }
}

fn date(bus: &BusStatistics) -> String {
    // 64 bits of nanoseconds reach to the year 2554, so every time has a date.
    let second = jiff::Timestamp::from_second((bus.first.nanos() / 1_000_000_000).cast_signed());
    second.map_or_else(|_| String::new(), |time| time.strftime("%Y-%m-%d %H:%M:%S").to_string())
}

/// The facts of the captures besides their frames.
fn captures(diagnosed: &Diagnosed<'_>) -> Markup {
    html! {
        @if !diagnosed.captures.is_empty() {
            details.quality {
                summary { "Quality of the capture" @if diagnosed.captures.len() > 1 { "s" } }
                pre { (crate::quality::text(diagnosed.captures, diagnosed.channels)) }
            }
        }
    }
}

fn tile(diagnosed: &Diagnosed<'_>, severity: Severity) -> Markup {
    let count = diagnosed.count(severity);
    html! {
        button.tile.(severity.name()) type="button" data-severity=(severity.name()) aria-pressed="false" disabled[count == 0] {
            span.count { (count) }
            span.name { (findings::badge(severity, count)) }
        }
    }
}
