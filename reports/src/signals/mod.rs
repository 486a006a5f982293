//! The values of PDOs as columns over time.
//!
//! A [`Sampler`] takes the frames and makes rows of them, a [`Sheet`] writes the rows. CSV has all columns in its first
//! line, before any row: its rows wait in a [`Spool`] until all columns are known.

mod columns;
mod csv;
mod json;
mod sampler;
mod spool;

pub use columns::{Column, Columns};
pub use csv::CsvSheet;
pub use json::JsonSheet;
pub use sampler::{SampleRow, Sampler};
pub use spool::Spool;

use std::io;

/// Writes rows of values.
pub trait Sheet {
    /// Takes the next row: `row.changed` holds what is new since the row before.
    ///
    /// # Errors
    /// If what has to wait can't be written to where it waits.
    fn row(&mut self, row: &SampleRow<'_>, columns: &Columns, out: &mut Vec<u8>) -> io::Result<()>;

    /// Appends what had to wait, a part at a time; `false` when there is no more.
    ///
    /// # Errors
    /// If what waits can't be read.
    fn finish(&mut self, columns: &Columns, out: &mut Vec<u8>) -> io::Result<bool>;
}
