//! JSON Lines: one object for each row, with all columns whose values are known.

use super::{Columns, SampleRow, Sheet};
use crate::decode::{push_number, push_schema};
use crate::push::{push_decimal, push_json_string, push_text};
use canvass_analyzer::Number;
use std::io;

/// Writes each row as a JSON line at once.
#[derive(Default)]
pub struct JsonSheet {
    begun: bool,
    latest: Vec<Option<Number>>,
    /// The names of the columns as JSON, with a comma before and a colon after.
    keys: Vec<Vec<u8>>,
}

/// The name and version of the contract.
const SCHEMA: &str = "canvass/signals/1";

impl JsonSheet {
    /// A sheet that has written nothing yet.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Sheet for JsonSheet {
    fn row(&mut self, row: &SampleRow<'_>, columns: &Columns, out: &mut Vec<u8>) -> io::Result<()> {
        for column in columns.iter().skip(self.keys.len()) {
            let mut key = vec![b','];
            push_json_string(&mut key, &column.name);
            key.push(b':');
            self.keys.push(key);
            self.latest.push(None);
        }
        for &(column, number) in row.changed {
            if let Some(latest) = self.latest.get_mut(column) {
                *latest = Some(number);
            }
        }
        out.push(b'{');
        if !std::mem::replace(&mut self.begun, true) {
            push_schema(SCHEMA, out);
        }
        out.extend_from_slice(b"\"t\":");
        push_decimal(out, row.time.nanos());
        if let Some(origin) = row.source {
            out.extend_from_slice(b",\"channel\":");
            push_json_string(out, origin.channel);
            push_text(out, format_args!(",\"node\":{},\"pdo\":\"{}\"", origin.node, origin.pdo));
        }
        for (key, number) in self.keys.iter().zip(&self.latest) {
            if let Some(number) = *number {
                out.extend_from_slice(key);
                push_number(number, out);
            }
        }
        out.extend_from_slice(b"}\n");
        Ok(())
    }

    fn finish(&mut self, _columns: &Columns, _out: &mut Vec<u8>) -> io::Result<bool> {
        Ok(false)
    }
}
