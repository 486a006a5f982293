//! A picture of the response times of the device: a bar for each answer, at its time.

use canvass_suite::bench::Exhibit;
use canvass_traces::{Direction, Duration, Timestamp};
use maud::{Markup, html};
use std::fmt::Write;

const WIDTH: u64 = 1_000;
const HEIGHT: u64 = 60;
/// Minimum number of answers for a picture; fewer answers can't be compared.
const LEAST: usize = 3;

/// An answer and its response time.
struct Delay {
    at: Timestamp,
    took: Duration,
}

/// A picture of the response times in a case, over its time. Empty if there are too few answers.
pub fn plot(frames: &[&Exhibit]) -> Markup {
    let delays = delays(frames);
    let times = || frames.iter().map(|exhibit| exhibit.record.timestamp);
    let (Some(start), Some(end), true) = (times().min(), times().max(), delays.len() >= LEAST) else {
        return html! {};
    };
    let longest = delays.iter().map(|delay| delay.took).max().unwrap_or(Duration::ZERO);
    let span = end.since(start);
    if span == Duration::ZERO || longest == Duration::ZERO {
        return html! {};
    }
    let sum: u64 = delays.iter().map(|delay| delay.took.nanos()).sum();
    // No bus has finer time stamps than a microsecond.
    let mean = Duration::from_nanos(sum / delays.len() as u64 / 1_000 * 1_000);
    let label = format!("{} answers of the device: {mean} on average, {longest} at most", delays.len());
    html! {
        svg.delays viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } preserveAspectRatio="none" role="img" aria-label=(label) {
            path.delay d=(bars(&delays, start, span, longest)) {}
            path.axis d={ "M0 " (HEIGHT) "h" (WIDTH) } {}
        }
        p.meta { (label) }
    }
}

/// The time from each frame of the tester to its answer. Frames that the device sends unasked are no answers.
fn delays(frames: &[&Exhibit]) -> Vec<Delay> {
    let mut asked = None;
    let mut delays = Vec::new();
    for record in frames.iter().map(|exhibit| &exhibit.record) {
        match (record.direction, asked) {
            (Direction::Tx, _) => asked = record.frame.cob_id().map(|cob_id| (cob_id, record.timestamp)),
            (_, Some((cob_id, since))) if record.frame.cob_id().is_some_and(|answer| is_answer(cob_id, answer)) => {
                delays.push(Delay { at: record.timestamp, took: record.timestamp.since(since) });
                asked = None;
            }
            _ => {}
        }
    }
    delays
}

/// Whether a received frame answers a frame of the tester: by SDO, LSS or node guarding.
const fn is_answer(request: u16, answer: u16) -> bool {
    match request {
        0x601..=0x67F => answer == request - 0x80,
        0x7E5 => answer == 0x7E4,
        0x701..=0x77F => answer == request,
        _ => false,
    }
}

/// The path of the drawing, with a line for each delay.
fn bars(delays: &[Delay], start: Timestamp, span: Duration, longest: Duration) -> String {
    let mut path = String::new();
    let scaled = |part: Duration, whole: Duration, room: u64| {
        u128::from(part.nanos()) * u128::from(room) / u128::from(whole.nanos().max(1))
    };
    for delay in delays {
        let x = scaled(delay.at.since(start), span, WIDTH);
        let height = scaled(delay.took, longest, HEIGHT).max(1);
        // Writing to a string can't fail.
        let _ = write!(path, "M{x} {HEIGHT}v-{height}");
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{CanId, ChannelId, Frame, Record};

    fn exhibit(micros: u64, id: u32, direction: Direction) -> Exhibit {
        let frame = Frame::full(CanId::standard(id).unwrap(), [0; 8]);
        let record = Record::new(Timestamp(micros * 1_000), ChannelId(0), frame).with_direction(direction);
        Exhibit { record, text: String::new() }
    }

    #[test]
    fn a_bar_for_each_answer() {
        let exhibits = [
            exhibit(0, 0x605, Direction::Tx),
            exhibit(100, 0x705, Direction::Rx),
            exhibit(500, 0x585, Direction::Rx),
            exhibit(600, 0x585, Direction::Rx),
            exhibit(1_000, 0x605, Direction::Tx),
            exhibit(2_000, 0x585, Direction::Rx),
            exhibit(3_000, 0x7E5, Direction::Tx),
            exhibit(4_000, 0x7E4, Direction::Rx),
        ];
        let frames: Vec<&Exhibit> = exhibits.iter().collect();
        let shown = plot(&frames).into_string();
        assert!(shown.contains("M125 60v-30M500 60v-60M1000 60v-60"), "{shown}");
        assert!(shown.contains("3 answers of the device: 833 µs on average, 1 ms at most"), "{shown}");
        assert!(plot(&frames[..4]).into_string().is_empty());
    }
}
