//! The values of PDOs over time for plots, with few points and every peak.

use super::buckets::{Buckets, Extremes};
use super::{Columns, SampleRow, Sheet};
use canvass_traces::{Duration, Timestamp};
use std::io;

/// Number of buckets, with up to two points each.
pub const BUCKETS: usize = 2048;
/// The width of the narrowest buckets.
const FINEST: Duration = Duration::from_millis(1);

/// Collects the values in bounded memory.
#[derive(Default)]
pub struct Series {
    start: Option<Timestamp>,
    /// The buckets in the order of the columns.
    columns: Vec<Buckets<Extremes, BUCKETS>>,
}

impl Series {
    /// Maximum number of kept columns. More would not fit into a page.
    pub const MOST: usize = 64;

    /// The points of a column, in the order of time.
    pub fn points(&self, column: usize) -> Vec<(Timestamp, f64)> {
        let samples = self.columns.get(column).into_iter().flat_map(Buckets::iter);
        let mut points: Vec<_> = samples.flat_map(Extremes::samples).collect();
        // The clock may have stepped back to before the start.
        points.sort_by_key(|point| point.0);
        points
    }
}

impl Sheet for Series {
    fn row(&mut self, row: &SampleRow<'_>, _columns: &Columns, _out: &mut Vec<u8>) -> io::Result<()> {
        let start = *self.start.get_or_insert(row.time);
        for &(column, number) in row.changed {
            let value = number.as_f64();
            if column >= Self::MOST {
                continue;
            }
            while self.columns.len() <= column {
                self.columns.push(Buckets::new(start, FINEST));
            }
            if let Some(buckets) = self.columns.get_mut(column).filter(|_| value.is_finite()) {
                buckets.add(row.time, Extremes::of(row.time, value));
            }
        }
        Ok(())
    }

    fn finish(&mut self, _columns: &Columns, _out: &mut Vec<u8>) -> io::Result<bool> {
        Ok(false)
    }
}
