//! Rules about the capture itself: what it can't prove, because it is not in it.
//!
//! These look at how far each source can be trusted; error frames are looked at where they stand.

mod bus_off;
mod clock_steps;
mod coarse_timestamps;
mod copies;
mod damaged;
mod dropped;
mod error_frames;
mod error_passive;
mod gaps;
mod overrun;

pub use copies::{RULE as COPIES, tell as tell_copies};

use super::diagnosis::SourceQuality;
use super::rule::{Definition, Thresholds};
use super::sink::{Findings, Sink};

pub static RULES: &[Definition] = &[
    damaged::RULE,
    dropped::RULE,
    overrun::RULE,
    copies::RULE,
    clock_steps::RULE,
    coarse_timestamps::RULE,
    gaps::RULE,
    error_frames::RULE,
    error_passive::RULE,
    bus_off::RULE,
];

/// A rule about a whole capture.
type Check = fn(usize, &SourceQuality<'_>, &Thresholds, &mut Sink<'_>);

static CHECKS: [(&Definition, Check); 5] = [
    (&damaged::RULE, damaged::check),
    (&dropped::RULE, dropped::check),
    (&clock_steps::RULE, clock_steps::check),
    (&coarse_timestamps::RULE, coarse_timestamps::check),
    (&gaps::RULE, gaps::check),
];

/// Looks at the sources of a capture.
pub fn check(sources: &[SourceQuality<'_>], thresholds: &Thresholds, findings: &mut Findings) {
    for (at, source) in sources.iter().enumerate() {
        for (definition, check) in &CHECKS {
            check(at, source, thresholds, &mut Sink { findings, rule: definition.metadata, bus: None });
        }
    }
}

/// The name of a file, without control characters.
fn name(source: &SourceQuality<'_>) -> String {
    source.name.escape_debug().to_string()
}
