//! CSV: a header with all columns, then the rows. Values that are not known yet are empty.

use super::{Columns, SampleRow, Sheet, Spool};
use crate::decode::push_number;
use crate::escape::push_csv_cell;
use crate::push::{push_decimal, push_text};
use canvass_analyzer::Number;
use std::io::{self, Read, Seek, Write};

/// Writes rows as CSV, after all columns are known.
pub struct CsvSheet<F: Read + Write + Seek> {
    spool: Spool<F>,
    /// The names of channels, to which rows refer by number.
    channels: Vec<String>,
    latest: Vec<Option<Number>>,
    by_pdo: bool,
    begun: bool,
}

/// Approximate number of bytes that one call of [`Sheet::finish`] appends.
const PART: usize = 64 * 1024;

impl<F: Read + Write + Seek> CsvSheet<F> {
    /// A sheet whose rows wait in the empty file `file`. `by_pdo`: each row is of one PDO and names it.
    pub const fn new(file: F, by_pdo: bool) -> Self {
        Self { spool: Spool::new(file), channels: Vec::new(), latest: Vec::new(), by_pdo, begun: false }
    }

    fn channel(&mut self, name: &str) -> u16 {
        let known = self.channels.iter().position(|known| known == name);
        let at = known.unwrap_or_else(|| {
            self.channels.push(name.to_owned());
            self.channels.len() - 1
        });
        at as u16
    }

    fn header(&self, columns: &Columns, out: &mut Vec<u8>) {
        out.extend_from_slice(if self.by_pdo { b"t [ns],channel,node,pdo" } else { b"t [ns]" });
        for column in columns.iter() {
            out.push(b',');
            push_csv_cell(out, &column.name);
        }
        out.push(b'\n');
    }
}

impl<F: Read + Write + Seek> Sheet for CsvSheet<F> {
    fn row(&mut self, row: &SampleRow<'_>, _columns: &Columns, _out: &mut Vec<u8>) -> io::Result<()> {
        let source = row.source.map(|origin| (self.channel(origin.channel), origin.node, origin.pdo));
        self.spool.keep(row.time, source, row.changed)
    }

    fn finish(&mut self, columns: &Columns, out: &mut Vec<u8>) -> io::Result<bool> {
        if !std::mem::replace(&mut self.begun, true) {
            self.header(columns, out);
            self.latest = vec![None; columns.len()];
        }
        while out.len() < PART {
            let Some(row) = self.spool.next()? else { return Ok(false) };
            for (column, number) in row.changed {
                if let Some(latest) = self.latest.get_mut(column) {
                    *latest = Some(number);
                }
            }
            push_decimal(out, row.time.nanos());
            if let Some((channel, node, pdo)) = row.source {
                out.push(b',');
                push_csv_cell(out, self.channels.get(usize::from(channel)).map_or("", |name| name));
                push_text(out, format_args!(",{node},{pdo}"));
            }
            for number in &self.latest {
                out.push(b',');
                match *number {
                    // A value that is not finite is written as text, because an empty cell means "not known".
                    Some(Number::Real32(value)) if !value.is_finite() => push_text(out, value),
                    Some(Number::Real64(value)) if !value.is_finite() => push_text(out, value),
                    Some(number) => push_number(number, out),
                    None => {}
                }
            }
            out.push(b'\n');
        }
        Ok(true)
    }
}
