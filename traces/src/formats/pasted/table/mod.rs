//! Tables whose head names the columns, separated by commas, semicolons or tabs.

mod head;
mod infer;
mod row;

use super::row::Miss;
use crate::Record;
use crate::columns::Unit;
use head::{Field, field, split, trim};
use row::Fields;

pub(super) use infer::infer;

/// A table.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Table {
    separator: u8,
    fields: Vec<Field>,
    /// The line with the names.
    head: Vec<u8>,
    id_is_decimal: bool,
    bytes_are_decimal: bool,
    /// Whether dates with slashes begin with the month.
    pub(super) month_first: bool,
    pub(super) unit: Unit,
}

/// A row, with the text of its time and channel.
pub(super) struct TableRow<'a> {
    pub(super) record: Record,
    pub(super) time: &'a [u8],
    pub(super) date: &'a [u8],
    pub(super) channel: &'a [u8],
    /// Whether the row may be the beginning of a longer one.
    pub(super) may_go_on: bool,
}

impl Table {
    fn by_head(line: &[u8]) -> Option<Self> {
        let by = |separator: u8| {
            let fields: Vec<Field> = line.split(|byte| *byte == separator).map(field).collect();
            let has = |wanted: &[Field]| fields.iter().any(|field| wanted.contains(field));
            let about_frames =
                [Field::Length, Field::Size, Field::Extended, Field::Direction, Field::Kind, Field::Channel];
            let has_id = fields.iter().any(|field| matches!(field, Field::Id(_)));
            let is_head = has_id && has(&[Field::Data, Field::Byte]) && has(&about_frames);
            is_head.then(|| Self {
                separator,
                fields,
                head: line.to_owned(),
                id_is_decimal: false,
                bytes_are_decimal: false,
                month_first: true,
                unit: Unit::Seconds,
            })
        };
        [b'\t', b',', b';'].into_iter().find_map(by)
    }

    /// The meaning of the columns in words.
    pub(super) fn describe(&self) -> String {
        let has = |wanted: fn(&Field) -> bool| self.fields.iter().any(wanted);
        let mut parts = vec!["a table with named columns".to_owned()];
        if has(|field| matches!(field, Field::Time(_))) {
            parts.push(format!("times in {}", self.unit.symbol()));
        } else if !has(|field| *field == Field::Date) {
            parts.push("no times".to_owned());
        }
        parts.extend(self.id_is_decimal.then(|| "id in decimal".to_owned()));
        parts.extend(self.bytes_are_decimal.then(|| "bytes in decimal".to_owned()));
        parts.join(", ")
    }

    /// Whether the line is the one with the names.
    pub(super) fn is_head(&self, line: &[u8]) -> bool {
        line == self.head
    }

    /// Whether a line that is no row looks like one: it has enough fields, and half of them have digits.
    pub(super) fn is_like_row(&self, line: &[u8]) -> bool {
        let texts = || line.split(|byte| *byte == self.separator).filter(|text| !text.trim_ascii().is_empty());
        let with_digits = texts().filter(|text| text.iter().any(u8::is_ascii_digit)).count();
        // The longer half of a row that a damaged byte splits has nearly half of the separators.
        2 * line.iter().filter(|byte| **byte == self.separator).count() + 2 >= self.fields.len()
            && 2 * with_digits >= texts().count()
    }

    /// Reads a row.
    pub(super) fn row<'a>(&self, line: &'a [u8]) -> Result<TableRow<'a>, Miss> {
        let mut row = Fields::default();
        let mut at = 0;
        let mut fields = self.fields.iter().copied();
        for text in split(line, self.separator) {
            // Fields after the last named one are further bytes of the data.
            let last = if self.fields.last() == Some(&Field::Data) { Field::Byte } else { Field::Other };
            row.take(fields.next().unwrap_or(last), trim(text), self).map_err(|what| (at, what))?;
            at += text.len() + 1;
        }
        row.bytes_are_fields = self.fields.contains(&Field::Byte);
        if let (true, Some(at)) = (row.time.is_empty() && row.date.is_empty(), row.no_time) {
            return Err((line.len().min(offset(line, at)), "a time"));
        }
        let record = row.record().map_err(|what| (0, what))?.with_direction(row.direction);
        let may_go_on = row.ends_in_digit || row.len.is_none() && record.frame.len() < 8;
        Ok(TableRow { record, time: row.time, date: row.date, channel: row.channel, may_go_on })
    }
}

/// The offset of a field in its line.
fn offset(line: &[u8], field: &[u8]) -> usize {
    (field.as_ptr() as usize).saturating_sub(line.as_ptr() as usize)
}
