//! A picture of the times of frames: sent frames above the line, received frames below.

use canvass_suite::bench::Exhibit;
use canvass_traces::{Direction, Duration, Timestamp};
use maud::{Markup, html};
use std::fmt::Write;

const WIDTH: u64 = 1_000;

/// The frames of a case over its time. Empty if there are too few.
pub fn strip(frames: &[&Exhibit]) -> Markup {
    let times = || frames.iter().map(|exhibit| exhibit.record.timestamp);
    let (Some(start), Some(end)) = (times().min(), times().max()) else { return html! {} };
    let span = end.since(start);
    if frames.len() < 3 || span == Duration::ZERO {
        return html! {};
    }
    let label = format!("{} frames in {span}, those of the tester above the line", frames.len());
    html! {
        svg.strip viewBox={ "0 0 " (WIDTH) " 40" } preserveAspectRatio="none" role="img" aria-label=(label) {
            path.sent d=(ticks(frames, start, span, true)) {}
            path.received d=(ticks(frames, start, span, false)) {}
            path.axis d={ "M0 20h" (WIDTH) } {}
        }
        p.meta.strip { span { "0" } span { (span) } }
    }
}

/// The path of the drawing, with a line for each frame.
fn ticks(frames: &[&Exhibit], start: Timestamp, span: Duration, sent: bool) -> String {
    let (mut path, top) = (String::new(), if sent { 3 } else { 22 });
    for exhibit in frames.iter().filter(|exhibit| (exhibit.record.direction == Direction::Tx) == sent) {
        let since = exhibit.record.timestamp.since(start).nanos();
        let x = u128::from(since) * u128::from(WIDTH) / u128::from(span.nanos().max(1));
        // Writing to a string can't fail.
        let _ = write!(path, "M{x} {top}v15");
    }
    path
}
