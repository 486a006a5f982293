//! Histograms of the response times of SDO servers.

use super::text;
use crate::diagnosis::Diagnosed;
use crate::diagnosis::node_table::rounded;
use canvass_analyzer::NodeId;
use canvass_analyzer::statistics::Histogram;
use canvass_traces::Duration;
use maud::{Markup, html};

/// Number of columns for each power of two.
const PER_OCTAVE: f64 = 4.0;
/// Number of powers of two. The histogram goes from 1 µs to 2^26 µs, which is more than a minute.
const OCTAVES: usize = 26;
const COLUMNS: usize = OCTAVES * PER_OCTAVE as usize;
/// Minimum number of shown columns.
const LEAST: usize = 40;
/// The width of the drawing.
const WIDTH: f64 = 520.0;
/// The height of the drawing.
const HEIGHT: f64 = 110.0;
/// Maximum number of nodes with a histogram of their own.
const MOST_NODES: usize = 24;

/// The section with a histogram for each node that was asked.
pub fn section(diagnosed: &Diagnosed<'_>) -> Markup {
    let several = diagnosed.results.buses.len() > 1;
    let nodes = diagnosed
        .results
        .buses
        .iter()
        .flat_map(|(channel, bus)| bus.nodes.iter().map(move |(id, node)| (*channel, *id, &node.responses)));
    // In a capture without time stamps all times are zero.
    let asked: Vec<_> = nodes.filter(|(.., times)| times.max() > Some(Duration::ZERO)).collect();
    let range = columns_of(asked.iter().map(|asked| asked.2));
    html! {
        section aria-labelledby="responses" {
            h2 #responses { "SDO response times" }
            @if asked.is_empty() {
                p.hint { "No SDO request was answered in this capture." }
            } @else {
                p.hint { "From a request to the server’s answer, on a logarithmic scale that all nodes share." }
                div.histograms {
                    @for (channel, id, times) in asked.iter().take(MOST_NODES) {
                        @let on = if several { format!(" on {}", text(&diagnosed.channel(*channel))) } else { String::new() };
                        (figure(*id, &on, times, range))
                    }
                }
                @if asked.len() > MOST_NODES { p.hint { (asked.len() - MOST_NODES) " more nodes: see their figures below." } }
            }
        }
    }
}

/// The column of a response time.
fn column(time: Duration) -> usize {
    let micros = time.nanos() as f64 / 1e3;
    ((micros.max(1.0).log2() * PER_OCTAVE) as usize).min(COLUMNS - 1)
}

/// The range of columns with values, with room on both sides.
fn columns_of<'a>(all: impl Iterator<Item = &'a Histogram>) -> (usize, usize) {
    let (first, last) = all.fold((COLUMNS, 0), |(first, last), times| {
        let of = |time: Option<Duration>| time.map_or(0, column);
        (first.min(of(times.min())), last.max(of(times.max())))
    });
    let (first, end) = (first.saturating_sub(2), (last + 3).min(COLUMNS));
    // The range has three decades at least, so that a single column does not fill the drawing.
    let missing = LEAST.saturating_sub(end.saturating_sub(first));
    (first.saturating_sub(missing / 2), (end + missing - missing / 2).min(COLUMNS))
}

fn figure(id: NodeId, on: &str, times: &Histogram, (first, end): (usize, usize)) -> Markup {
    let mut counts = vec![0_u64; COLUMNS];
    for (time, count) in times.rows() {
        counts[column(time)] += u64::from(count);
    }
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    let width = WIDTH / end.saturating_sub(first).max(1) as f64;
    let shown = |time: Option<Duration>| time.map(|time| rounded(time).to_string()).unwrap_or_default();
    let [median, late, worst] = [times.quantile(50), times.quantile(99), times.max()].map(shown);
    let words = format!("{} responses: half within {median}, 99 % within {late}, the longest {worst}", times.count());
    html! {
        figure.card.histogram {
            figcaption { strong { "Node " (id) (on) } span { "p50 " (median) " · p99 " (late) " · max " (worst) " · " (times.count()) " answers" } }
            svg viewBox={ "0 0 " (WIDTH) " " (HEIGHT + 18.0) } role="img" aria-label=(words) {
                @for decade in 0..=8 {
                    @let x = (f64::from(decade) * 10_f64.log2() * PER_OCTAVE - first as f64) * width;
                    @if (0.0..WIDTH - 45.0).contains(&x) {
                        line.grid x1=(px(x)) x2=(px(x)) y1="0" y2=(HEIGHT) {}
                        text x=(px(x + 3.0)) y=(HEIGHT + 14.0) { (Duration::from_micros(10_u64.pow(decade))) }
                    }
                }
                @for (at, &count) in counts.iter().enumerate().take(end).skip(first).filter(|column| *column.1 > 0) {
                    // A single value among a million must still be visible.
                    @let height = (count as f64 / most as f64 * (HEIGHT - 6.0)).max(2.0);
                    rect.bar x=(px((at - first) as f64 * width + 1.0)) y=(px(HEIGHT - height)) width=(px((width - 2.0).max(1.0))) height=(px(height)) rx="1.5" {
                        title { (count) " up to " (rounded(upper(at))) }
                    }
                }
                line.axis x1="0" x2=(WIDTH) y1=(HEIGHT) y2=(HEIGHT) {}
            }
        }
    }
}

/// The longest response time of a column.
fn upper(column: usize) -> Duration {
    Duration((((column + 1) as f64 / PER_OCTAVE).exp2() * 1e3) as u64)
}

fn px(value: f64) -> String {
    format!("{value:.1}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_grow_with_times() {
        assert_eq!(column(Duration(1)), 0);
        assert_eq!(column(Duration::from_micros(16)), 16);
        assert_eq!(column(Duration(u64::MAX)), COLUMNS - 1);
        assert!(upper(16) > Duration::from_micros(16) && upper(15) <= Duration::from_micros(16));
    }
}
