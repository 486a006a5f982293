//! What failed comes first.

use super::case::anchor;
use crate::conformance::Run;
use crate::conformance::screen::is_bad;
use crate::conformance::{quarantined, symbol};
use crate::escape::printable;
use canvass_suite::runner::CaseReport;
use maud::{Markup, html};

fn bad(run: &Run) -> impl Iterator<Item = &CaseReport> {
    run.cases.iter().filter(|report| is_bad(report.verdict.kind()))
}

/// Whether somebody has to look into something.
pub fn any(run: &Run) -> bool {
    bad(run).next().is_some()
}

/// All cases: first those that failed or could not be judged, then the others, each as they ran.
pub fn first(run: &Run) -> impl Iterator<Item = &CaseReport> {
    bad(run).chain(run.cases.iter().filter(|report| !is_bad(report.verdict.kind())))
}

/// Each with why, linked to what there is about it.
pub fn section(run: &Run) -> Markup {
    html! {
        @if any(run) {
            section {
                h2 #failed { "Failed" }
                ul.failed {
                    @for report in bad(run) {
                        @let kind = report.verdict.kind();
                        @let reason = report.verdict.reason().unwrap_or_default();
                        li {
                            a href={ "#" (anchor(report)) } {
                                span.badge.(kind.name()) { span aria-hidden="true" { (symbol(kind)) " " } (kind.title()) }
                                " " span.id { (report.case.id) }
                            }
                            " " span.why {
                                @if let Some(quarantined) = quarantined(report) { (quarantined) "; " }
                                (printable(&reason.to_string()))
                            }
                        }
                    }
                }
            }
        }
    }
}
