//! Times as texts. Captures have thousands of frames a second, so the text of a second is made once for all its frames.

use datafusion::arrow::array::{Array, ArrayRef, AsArray, TimestampNanosecondArray};
use datafusion::arrow::datatypes::{DataType, TimeUnit, TimestampNanosecondType};
use datafusion::arrow::error::ArrowError;
use datafusion::arrow::util::display::{ArrayFormatter, FormatOptions};
use std::fmt::Write;

const SECOND: i64 = 1_000_000_000;

/// Writes the values of a column as Arrow does; writes nothing for null.
pub struct Texts<'a> {
    formatter: ArrayFormatter<'a>,
    /// The column, if it has nanoseconds in UTC.
    times: Option<&'a TimestampNanosecondArray>,
    /// The second of the last time, and the text of that time without its fraction.
    second: Option<(i64, String)>,
}

impl<'a> Texts<'a> {
    /// The texts of this column.
    ///
    /// # Errors
    /// [`ArrowError`] if Arrow can't write values of this type.
    pub fn new(column: &'a ArrayRef, options: &FormatOptions<'a>) -> Result<Self, ArrowError> {
        let is_utc =
            matches!(column.data_type(), DataType::Timestamp(TimeUnit::Nanosecond, Some(zone)) if &**zone == "UTC");
        let times = is_utc.then(|| column.as_primitive::<TimestampNanosecondType>());
        Ok(Self { formatter: ArrayFormatter::try_new(column, options)?, times, second: None })
    }

    /// Appends the value of this row.
    ///
    /// # Errors
    /// [`ArrowError`] if a value can't be written, such as a time outside the calendar.
    pub fn write(&mut self, row: usize, out: &mut String) -> Result<(), ArrowError> {
        let Some(times) = self.times.filter(|times| times.is_valid(row)) else {
            return self.formatter.value(row).write(out);
        };
        let time = times.value(row);
        if let Some((second, text)) = &self.second
            && *second == time.div_euclid(SECOND)
        {
            out.push_str(text);
            push_fraction(out, time.rem_euclid(SECOND));
            out.push('Z');
            return Ok(());
        }
        let begin = out.len();
        self.formatter.value(row).write(out)?;
        let text = out.get(begin..).unwrap_or_default();
        let seconds = text.split(['.', 'Z']).next().unwrap_or_default();
        self.second = Some((time.div_euclid(SECOND), seconds.to_owned()));
        Ok(())
    }
}

/// Appends a point and three, six or nine digits, as many as needed; appends nothing for 0.
fn push_fraction(out: &mut String, nanos: i64) {
    // Writing to a string can't fail.
    let _ = match nanos {
        0 => Ok(()),
        _ if nanos % 1_000_000 == 0 => write!(out, ".{:03}", nanos / 1_000_000),
        _ if nanos % 1_000 == 0 => write!(out, ".{:06}", nanos / 1_000),
        _ => write!(out, ".{nanos:09}"),
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::sync::Arc;

    proptest! {
        /// The times lie closely together, with few or many digits, before and after 1970.
        #[test]
        fn as_arrow_writes_them(
            begin in any::<i64>(),
            steps in prop::collection::vec((0..3_i64, prop::sample::select(vec![1, 1_000, 1_000_000, SECOND])), 1..20),
            zone in prop::sample::select(vec!["UTC", "+01:00"]),
        ) {
            let mut time = begin / 2 - (begin / 2) % SECOND;
            let times = steps.into_iter().map(|(n, unit)| {
                time += n * unit;
                (n < 2).then_some(time)
            });
            let column: ArrayRef = Arc::new(TimestampNanosecondArray::from_iter(times).with_timezone(zone));
            let options = FormatOptions::default();
            let (mut texts, whole) = (Texts::new(&column, &options)?, ArrayFormatter::try_new(&column, &options)?);
            for row in 0..column.len() {
                let mut text = String::new();
                texts.write(row, &mut text)?;
                prop_assert_eq!(text, whole.value(row).to_string());
            }
        }
    }
}
