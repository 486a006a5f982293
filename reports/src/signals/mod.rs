//! The values of PDOs as columns over time.
//!
//! A [`Sampler`] turns frames into rows, and a [`Sheet`] writes the rows. CSV has all columns in its first line, so its
//! rows wait in a [`Spool`] until all columns are known.

pub(crate) mod buckets;
mod columns;
mod csv;
mod dropped;
mod json;
mod sampler;
pub(crate) mod series;
mod spool;

pub use columns::{Column, Columns};
pub use csv::CsvSheet;
pub use dropped::Dropped;
pub use json::JsonSheet;
pub use sampler::{SampleRow, Sampler};
pub use series::Series;
pub use spool::Spool;

use std::io;

/// Writes rows of values.
pub trait Sheet {
    /// Takes the next row. `row.changed` contains the values that are new since the previous row.
    ///
    /// # Errors
    /// An error if a waiting row can't be stored.
    fn row(&mut self, row: &SampleRow<'_>, columns: &Columns, out: &mut Vec<u8>) -> io::Result<()>;

    /// Appends waiting rows, a part at a time. `false` when there are no more.
    ///
    /// # Errors
    /// An error if a waiting row can't be read.
    fn finish(&mut self, columns: &Columns, out: &mut Vec<u8>) -> io::Result<bool>;
}
