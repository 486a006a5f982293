//! Rules about the capture itself: missing parts and unreliable times limit its evidence.
//!
//! These rules look at the quality of each source; rules on error frames look at the frames.

mod bus_off;
mod clock_steps;
mod coarse_timestamps;
mod copies;
mod damaged;
mod dropped;
mod error_flood;
mod error_frames;
mod error_passive;
mod gaps;
mod out_of_order;
mod overrun;

pub use copies::{Copies, tell as tell_copies};
pub use out_of_order::{OutOfOrder, tell as tell_disorder};

use super::registry;
use super::rule::Make;
use super::sink::{Findings, Sink};
use super::source::SourceQuality;
use super::thresholds::Thresholds;

/// Checks the sources of a capture.
pub fn check(sources: &[SourceQuality<'_>], thresholds: &Thresholds, findings: &mut Findings) {
    for definition in registry::all() {
        let Make::Capture(make) = definition.make else { continue };
        let rule = make(thresholds);
        for (at, source) in sources.iter().enumerate() {
            rule.check(at, source, &mut Sink { findings, rule: definition.metadata, bus: None });
        }
    }
}

/// The name of a file, without control characters.
fn name(source: &SourceQuality<'_>) -> String {
    source.name.escape_debug().to_string()
}
