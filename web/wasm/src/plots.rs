//! Values of PDOs over time, for drawing.

use crate::trace::store::{Store, Walk};
use canvass_analyzer::Meaning;
use canvass_reports::escape::printable;
use canvass_reports::signals::{Columns, SampleRow, Sampler, Sheet};
use canvass_traces::{Channels, Timestamp};
use serde_json::{Value, json};
use std::io;
use std::ops::ControlFlow;

/// The collected values, and the state of collecting.
pub struct Plots {
    walk: Option<Walk>,
    sampler: Sampler,
    series: AllSeries,
}

/// The values of all columns.
struct AllSeries {
    start: Timestamp,
    all: Vec<Series>,
    points: usize,
    /// Number of consecutive values of which only the least and the greatest are kept.
    thinned: usize,
}

/// Times in seconds since the start, and values.
#[derive(Default)]
struct Series(Vec<(f64, f64)>);

impl Sheet for AllSeries {
    fn row(&mut self, row: &SampleRow<'_>, columns: &Columns, _: &mut Vec<u8>) -> io::Result<()> {
        self.all.resize_with(columns.len(), Series::default);
        let time = seconds(self.start, row.time);
        for &(column, number) in row.changed {
            if let Some(series) = self.all.get_mut(column) {
                series.0.push((time, number.as_f64()));
                self.points += 1;
            }
        }
        if self.points > Plots::MOST {
            self.thin();
        }
        Ok(())
    }

    fn finish(&mut self, _: &Columns, _: &mut Vec<u8>) -> io::Result<bool> {
        Ok(false)
    }
}

impl AllSeries {
    fn thin(&mut self) {
        self.thinned = self.thinned.max(1) * 2;
        for series in &mut self.all {
            series.0 = series.0.chunks(4).flat_map(extremes).collect();
        }
        self.points = self.all.iter().map(|series| series.0.len()).sum();
    }
}

impl Plots {
    /// Maximum number of values in all columns together.
    const MOST: usize = 4_000_000;

    /// Begins the collection, without values.
    pub fn new(store: &Store) -> Self {
        let start = store.start().unwrap_or_default();
        let series = AllSeries { start, all: Vec::new(), points: 0, thinned: 1 };
        Self { walk: store.walk(0), sampler: Sampler::new(None), series }
    }

    /// Collects values from the next records; `false` at the end.
    ///
    /// # Errors
    /// None in practice: nothing is written.
    pub fn step(&mut self, store: &Store, records: usize, channels: &Channels) -> io::Result<bool> {
        let Some(walk) = &mut self.walk else { return Ok(false) };
        let (sampler, series) = (&mut self.sampler, &mut self.series);
        let mut went = Ok(());
        walk.until(store, walk.row().saturating_add(records), |step| {
            let Some(bus) = step.network.bus(step.record.channel) else { return ControlFlow::Continue(()) };
            let meaning = Meaning::new(step.record, &step.decoded, bus);
            went = sampler.frame(step.record, channels, &step.decoded, &meaning, series, &mut Vec::new());
            if went.is_ok() { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        });
        went.map(|()| walk.row() < store.len())
    }

    /// Number of examined records.
    pub fn looked_at(&self) -> usize {
        self.walk.as_ref().map_or(0, Walk::row)
    }

    /// The columns that can be drawn.
    pub fn columns(&self) -> Value {
        let columns = self.sampler.columns().iter().zip(&self.series.all).map(|(column, series)| {
            json!({
                "name": printable(&column.name),
                "label": printable(&column.label),
                "unit": printable(&column.unit),
                "node": column.node.raw(),
                "values": series.0.len(),
            })
        });
        json!({ "columns": columns.collect::<Vec<_>>(), "leftOut": self.sampler.columns().left_out, "thinned": self.series.thinned })
    }

    /// Times and values of a column between two times, alternating. Each of `parts` equal spans has at most its least
    /// and its greatest value. The last value before the range and the first value after it are included, so that lines
    /// continue at both ends.
    pub fn points(&self, column: usize, from: f64, to: f64, parts: usize) -> Vec<f64> {
        let Some(Series(points)) = self.series.all.get(column) else { return Vec::new() };
        // If the clock of the capture stepped back, the line does, too.
        let first = points.iter().position(|point| point.0 >= from).unwrap_or(points.len()).saturating_sub(1);
        let last = points.iter().rposition(|point| point.0 <= to).map_or(0, |at| at + 2).min(points.len());
        let shown = points.get(first..last).unwrap_or_default();
        if shown.len() <= 2 * parts {
            return shown.iter().flat_map(|&(time, value)| [time, value]).collect();
        }
        let size = shown.len().div_ceil(parts.max(1));
        shown.chunks(size).flat_map(extremes).flat_map(|(time, value)| [time, value]).collect()
    }
}

/// The least and the greatest value, in the order of their times.
fn extremes(part: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
    let (Some(least), Some(greatest)) = (part.iter().min_by(by_value), part.iter().max_by(by_value)) else {
        return Vec::new();
    };
    match least.0.total_cmp(&greatest.0) {
        std::cmp::Ordering::Less => vec![*least, *greatest],
        std::cmp::Ordering::Equal => vec![*least],
        std::cmp::Ordering::Greater => vec![*greatest, *least],
    }
}

fn seconds(start: Timestamp, time: Timestamp) -> f64 {
    let nanos = i128::from(time.nanos()) - i128::from(start.nanos());
    nanos as f64 / 1e9
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_thinned_out_keeps_its_extremes() {
        let points: Vec<_> = (0..100).map(|n| (f64::from(n), f64::from(n * 37 % 101))).collect();
        let thin: Vec<_> = points.chunks(10).flat_map(extremes).collect();
        assert_eq!(thin.len(), 20);
        assert!(thin.is_sorted_by(|a, b| a.0 <= b.0));
        let greatest = |points: &[(f64, f64)]| points.iter().map(|point| point.1).fold(f64::MIN, f64::max);
        assert_eq!(greatest(&thin), greatest(&points));
    }
}
