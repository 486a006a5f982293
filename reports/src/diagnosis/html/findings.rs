//! The findings, each with its frames.

use super::excerpt::{FrameKey, key_of};
use super::{MOST_FINDINGS, frame_link, text};
use crate::diagnosis::{Diagnosed, frame, times};
use canvass_analyzer::findings::{Exhibit, Finding, Severity};
use maud::{Markup, html};
use std::collections::HashMap;

/// The anchor of a finding by its number from 0.
pub fn anchor(at: usize) -> String {
    format!("finding-{}", at + 1)
}

/// A severity with a sign, which distinguishes severities without colours.
pub(crate) fn badge(severity: Severity, count: usize) -> Markup {
    let (sign, name) = match severity {
        Severity::Error => ("✕", "Error"),
        Severity::Warning => ("▲", "Warning"),
        Severity::Info => ("●", "Hint"),
    };
    html! { span.badge.(severity.name()) { span aria-hidden="true" { (sign) " " } (name) @if count != 1 { "s" } } }
}

/// All shown findings, the worst first.
pub fn section(diagnosed: &Diagnosed<'_>, places: &HashMap<FrameKey, usize>) -> Markup {
    let all = &diagnosed.results.findings;
    html! {
        section aria-labelledby="findings" {
            h2 #findings { "Findings" }
            @if all.is_empty() {
                p.nothing.card { "Nothing of what canvass looks for has happened on this bus." }
            } @else {
                div.filter role="search" aria-label="Findings" {
                    input #finding-text type="search" placeholder="Filter by rule, node or text" aria-label="Filter by rule, node or text";
                    span #findings-shown role="status" {}
                }
            }
            @for (at, finding, of) in in_stories(diagnosed).take(MOST_FINDINGS) {
                (article(diagnosed, at, finding, of, places))
            }
            @if all.len() > MOST_FINDINGS { p.hint { (all.len() - MOST_FINDINGS) " more findings are not shown." } }
            @for (rule, count) in &diagnosed.results.omitted {
                p.hint { (rule) ": " (count) " more reports are not shown." }
            }
        }
    }
}

/// The findings at the heads of the stories, each with its position.
pub fn heads<'a>(diagnosed: &'a Diagnosed<'_>) -> impl Iterator<Item = (usize, &'a Finding)> {
    let first = diagnosed.results.stories.iter().filter_map(|story| story.head.first());
    first.filter_map(|at| Some((*at, diagnosed.results.findings.get(*at)?)))
}

/// All findings in the order of their stories: the position, and the position of the finding from which it follows.
fn in_stories<'a>(diagnosed: &'a Diagnosed<'_>) -> impl Iterator<Item = (usize, &'a Finding, Option<usize>)> {
    let heads_and_rest = diagnosed.results.stories.iter().flat_map(|story| {
        let head = story.head.iter().map(|at| (*at, None));
        let rest = story.consequences.iter();
        let rest = rest.flat_map(|consequence| consequence.findings.iter().map(|at| (*at, Some(consequence.of))));
        head.chain(rest)
    });
    heads_and_rest.filter_map(|(at, of)| Some((at, diagnosed.results.findings.get(at)?, of)))
}

fn article(
    diagnosed: &Diagnosed<'_>,
    at: usize,
    finding: &Finding,
    of: Option<usize>,
    places: &HashMap<FrameKey, usize>,
) -> Markup {
    let title = format!("title-{}", at + 1);
    let cause = of.and_then(|of| Some((of, diagnosed.results.findings.get(of)?)));
    html! {
        article.finding.card.follows[cause.is_some()].(finding.severity.name()) id=(anchor(at)) data-severity=(finding.severity.name()) tabindex="-1" aria-labelledby=(title) {
            header {
                (badge(finding.severity, 1))
                h3 id=(title) { (finding.rule.title) }
                code.rule { (finding.rule.id) }
            }
            p.where {
                @let whom = text(&diagnosed.whom(finding));
                @if !whom.is_empty() { strong { (whom) } " · " }
                button.link type="button" data-from=(micros(diagnosed, finding.first)) data-to=(micros(diagnosed, finding.last)) title="Show this time in the plots" {
                    "at " (diagnosed.since_start(finding.first)) " s"
                }
                (times(diagnosed, finding))
            }
            p.message { (text(&finding.message)) }
            @if let Some((of, cause)) = cause {
                p.cause { span aria-hidden="true" { "↳ " } "follows from " a href={ "#" (anchor(of)) } { (text(&diagnosed.whom(cause))) @if cause.node.is_some() { ": " } (cause.rule.title) } }
            }
            (evidence(diagnosed, finding, places))
            p.advice { strong { "What to do: " } (finding.rule.advice) }
            details.why {
                summary { "Why this matters" }
                p { (finding.rule.what) }
                p { (finding.rule.why) }
            }
        }
    }
}

/// The time in microseconds since the start.
fn micros(diagnosed: &Diagnosed<'_>, time: canvass_traces::Timestamp) -> u64 {
    diagnosed.start().map_or(0, |start| time.since(start).nanos() / 1_000)
}

fn evidence(diagnosed: &Diagnosed<'_>, finding: &Finding, places: &HashMap<FrameKey, usize>) -> Markup {
    html! {
        @if !finding.evidence.is_empty() {
            div.scroll {
                table.evidence {
                    caption.unseen { "The frames that prove it" }
                    thead.unseen { tr {
                        th scope="col" { "Place" } th scope="col" { "Time [s]" } th scope="col" { "Frame" } th scope="col" { "Meaning" }
                    } }
                    tbody { @for exhibit in &finding.evidence { (row(diagnosed, exhibit, places)) } }
                }
            }
        }
    }
}

fn row(diagnosed: &Diagnosed<'_>, exhibit: &Exhibit, places: &HashMap<FrameKey, usize>) -> Markup {
    let at = key_of(exhibit).and_then(|key| places.get(&key));
    let number = format!("#{}", exhibit.place.number);
    html! {
        tr {
            td.number {
                @match at {
                    Some(at) => a.frame href=(frame_link(*at)) title="Show this frame among its neighbours" { (number) },
                    None => (number),
                }
            }
            td.number { (diagnosed.since_start(exhibit.time)) }
            td.bytes { (text(&shortened(frame(exhibit)))) }
            td.text { (text(&exhibit.text)) }
        }
    }
}

/// Shortens the text of a frame, because a frame of CAN XL may have 2048 bytes.
fn shortened(frame: String) -> String {
    const MOST: usize = 160;
    match frame.char_indices().nth(MOST) {
        Some((at, _)) => format!("{}…", frame.get(..at).unwrap_or_default()),
        None => frame,
    }
}
