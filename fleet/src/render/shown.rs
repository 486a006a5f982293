//! Converts columns for text formats: bytes to hexadecimal digits, times to the form of each format.

use datafusion::arrow::array::{Array, ArrayRef, AsArray, RecordBatch, StringArray};
use datafusion::arrow::compute::cast;
use datafusion::arrow::datatypes::{DataType, Field, Schema};
use datafusion::arrow::error::ArrowError;
use std::sync::Arc;

/// Converts bytes to upper-case hexadecimal digits; other columns stay unchanged.
pub fn with_digits(batch: &RecordBatch) -> Result<RecordBatch, ArrowError> {
    changed(batch, |column| match column.data_type() {
        DataType::Binary => Ok(digits(column.as_binary::<i32>().iter())),
        DataType::LargeBinary => Ok(digits(column.as_binary::<i64>().iter())),
        DataType::BinaryView => Ok(digits(column.as_binary_view().iter())),
        _ => Ok(Arc::clone(column)),
    })
}

/// Converts bytes to upper-case hexadecimal digits and times to integer nanoseconds, as in all JSON outputs.
pub fn for_json(batch: &RecordBatch) -> Result<RecordBatch, ArrowError> {
    changed(&with_digits(batch)?, |column| match column.data_type() {
        DataType::Timestamp(_, zone) => {
            let nanos = DataType::Timestamp(datafusion::arrow::datatypes::TimeUnit::Nanosecond, zone.clone());
            cast(&cast(column, &nanos)?, &DataType::Int64)
        }
        DataType::Duration(_) => {
            let nanos = DataType::Duration(datafusion::arrow::datatypes::TimeUnit::Nanosecond);
            cast(&cast(column, &nanos)?, &DataType::Int64)
        }
        _ => Ok(Arc::clone(column)),
    })
}

fn digits<'a>(values: impl Iterator<Item = Option<&'a [u8]>>) -> ArrayRef {
    let hex = |bytes: &[u8]| canvass_traces::hex::compact(bytes).to_string();
    Arc::new(values.map(|bytes| bytes.map(hex)).collect::<StringArray>())
}

fn changed(
    batch: &RecordBatch,
    change: impl Fn(&ArrayRef) -> Result<ArrayRef, ArrowError>,
) -> Result<RecordBatch, ArrowError> {
    let columns = batch.columns().iter().map(&change).collect::<Result<Vec<_>, _>>()?;
    let field = |(field, column): (&Arc<Field>, &ArrayRef)| Field::new(field.name(), column.data_type().clone(), true);
    let schema = Schema::new(batch.schema().fields().iter().zip(&columns).map(field).collect::<Vec<_>>());
    let options = datafusion::arrow::array::RecordBatchOptions::new().with_row_count(Some(batch.num_rows()));
    RecordBatch::try_new_with_options(Arc::new(schema), columns, &options)
}
