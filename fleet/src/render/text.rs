//! Answers as text. Texts of captures may be hostile: no character of them controls a terminal or a spreadsheet.

use super::Answer;
use super::shown::{for_json, with_digits};
use super::times::Texts;
use canvass_reports::escape;
use datafusion::arrow::array::{ArrayRef, RecordBatch, StringArray};
use datafusion::arrow::datatypes::{DataType, Field, Schema, SchemaRef};
use datafusion::arrow::error::ArrowError;
use datafusion::arrow::json::writer::LineDelimited;
use datafusion::arrow::util::display::{ArrayFormatter, FormatOptions};
use datafusion::arrow::util::pretty::pretty_format_batches_with_schema;
use datafusion::error::Result;
use std::io::{self, Write};
use std::sync::Arc;

/// The texts of a column, one for each row; `None` for null.
fn texts(column: &ArrayRef) -> Result<Vec<Option<String>>, ArrowError> {
    let formatter = ArrayFormatter::try_new(column, &FormatOptions::default())?;
    let text = |row: usize| match column.is_null(row) {
        true => Ok(None),
        false => Ok(Some(formatter.value(row).try_to_string()?)),
    };
    (0..column.len()).map(text).collect()
}

/// A table for people. Its column widths depend on all rows, so that the rows wait until the answer is complete.
pub struct Table<'a> {
    schema: SchemaRef,
    batches: Vec<RecordBatch>,
    out: Box<dyn Write + Send + 'a>,
}

impl<'a> Table<'a> {
    pub fn new(schema: &SchemaRef, out: Box<dyn Write + Send + 'a>) -> Self {
        let text = |field: &Arc<Field>| Field::new(escape::printable(field.name()), DataType::Utf8, true);
        let schema = Schema::new(schema.fields().iter().map(text).collect::<Vec<_>>());
        Self { schema: Arc::new(schema), batches: Vec::new(), out }
    }
}

impl Answer for Table<'_> {
    fn batch(&mut self, batch: &RecordBatch) -> Result<()> {
        let printable = |text: Option<String>| text.map(|text| escape::document(&text).into_owned());
        let column = |column: &ArrayRef| -> Result<ArrayRef, ArrowError> {
            Ok(Arc::new(texts(column)?.into_iter().map(printable).collect::<StringArray>()))
        };
        let columns = with_digits(batch)?.columns().iter().map(column).collect::<Result<Vec<_>, _>>()?;
        let options = datafusion::arrow::array::RecordBatchOptions::new().with_row_count(Some(batch.num_rows()));
        self.batches.push(RecordBatch::try_new_with_options(SchemaRef::clone(&self.schema), columns, &options)?);
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        let table = pretty_format_batches_with_schema(SchemaRef::clone(&self.schema), &self.batches)?;
        writeln!(self.out, "{table}")?;
        Ok(self.out.flush()?)
    }
}

/// JSON Lines: an object for each row.
pub struct JsonLines<'a> {
    writer: datafusion::arrow::json::Writer<Escaped<'a>, LineDelimited>,
}

/// A writer of JSON that escapes control characters in texts.
struct Escaped<'a>(Box<dyn Write + Send + 'a>);

impl Write for Escaped<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Arrow writes whole rows, and its texts are UTF-8.
        match std::str::from_utf8(bytes) {
            Ok(text) => self.0.write_all(escape::json(text).as_bytes())?,
            Err(error) => return Err(io::Error::other(error)),
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl<'a> JsonLines<'a> {
    pub fn new(out: Box<dyn Write + Send + 'a>) -> Self {
        let builder = datafusion::arrow::json::WriterBuilder::new().with_explicit_nulls(true);
        Self { writer: builder.build::<_, LineDelimited>(Escaped(out)) }
    }
}

impl Answer for JsonLines<'_> {
    fn batch(&mut self, batch: &RecordBatch) -> Result<()> {
        Ok(self.writer.write(&for_json(batch)?)?)
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().flush()?)
    }
}

/// Comma-separated values; null is an empty cell.
pub struct Csv<'a> {
    out: Box<dyn Write + Send + 'a>,
    /// The lines of the current batch, and the current cell.
    lines: Vec<u8>,
    cell: String,
}

impl<'a> Csv<'a> {
    pub fn new(schema: &SchemaRef, mut out: Box<dyn Write + Send + 'a>) -> Result<Self> {
        let names: Vec<String> = schema.fields().iter().map(|field| escape::csv_cell(field.name())).collect();
        writeln!(out, "{}", names.join(","))?;
        Ok(Self { out, lines: Vec::new(), cell: String::new() })
    }
}

impl Answer for Csv<'_> {
    fn batch(&mut self, batch: &RecordBatch) -> Result<()> {
        let (shown, options) = (with_digits(batch)?, FormatOptions::default());
        let columns = shown.columns().iter().map(|column| Texts::new(column, &options));
        let mut columns = columns.collect::<Result<Vec<_>, _>>()?;
        self.lines.clear();
        for row in 0..shown.num_rows() {
            for (at, column) in columns.iter_mut().enumerate() {
                if at > 0 {
                    self.lines.push(b',');
                }
                self.cell.clear();
                column.write(row, &mut self.cell)?;
                escape::push_csv_cell(&mut self.lines, &self.cell);
            }
            self.lines.push(b'\n');
        }
        Ok(self.out.write_all(&self.lines)?)
    }

    fn finish(mut self: Box<Self>) -> Result<()> {
        Ok(self.out.flush()?)
    }
}
