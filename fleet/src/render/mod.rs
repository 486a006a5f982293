//! Output of answers: tables for people, JSON Lines, CSV, Parquet and Arrow.

mod binary;
mod shown;
mod text;
mod times;

use datafusion::arrow::array::RecordBatch;
use datafusion::arrow::datatypes::SchemaRef;
use datafusion::error::Result;
use std::io::Write;

/// How an answer is printed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, clap::ValueEnum)]
pub enum Format {
    /// A table for people
    #[default]
    Table,
    /// JSON Lines: times are integer nanoseconds, bytes are hexadecimal digits
    Json,
    /// Comma-separated values with a header
    Csv,
    /// Parquet, as a file
    Parquet,
    /// Arrow IPC stream
    Arrow,
}

impl Format {
    /// Whether a file of the format holds one answer.
    pub const fn is_one_document(self) -> bool {
        matches!(self, Self::Csv | Self::Parquet | Self::Arrow)
    }

    /// Whether the format is not for terminals.
    pub const fn is_binary(self) -> bool {
        matches!(self, Self::Parquet | Self::Arrow)
    }
}

/// A writer of an answer, batch by batch.
pub trait Answer {
    /// Writes a batch.
    ///
    /// # Errors
    /// If the batch can't be written.
    fn batch(&mut self, batch: &RecordBatch) -> Result<()>;

    /// Writes the rest and completes the answer.
    ///
    /// # Errors
    /// If the rest can't be written.
    fn finish(self: Box<Self>) -> Result<()>;
}

/// A writer of an answer with this schema in this format.
///
/// # Errors
/// If the header can't be written.
pub fn answer<'a>(format: Format, schema: &SchemaRef, out: Box<dyn Write + Send + 'a>) -> Result<Box<dyn Answer + 'a>> {
    Ok(match format {
        Format::Table => Box::new(text::Table::new(schema, out)),
        Format::Json => Box::new(text::JsonLines::new(out)),
        Format::Csv => Box::new(text::Csv::new(schema, out)?),
        Format::Parquet => Box::new(binary::Parquet::new(schema, out)?),
        Format::Arrow => Box::new(binary::Arrow::new(schema, out)?),
    })
}

#[cfg(test)]
mod tests;
