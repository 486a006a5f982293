//! Infers what the head of a table does not say.

use super::super::clock::{order, plain, units};
use super::super::question::Question;
use super::Table;
use super::head::{Field, split, trim};
use super::row::is_time;
use crate::CanId;
use crate::columns::{Columns, IdForm, Radix, Unit};
use crate::lines::head_lines;

/// Number of lines in which the head is searched for, and of rows that decide.
const LINES: usize = 100;

/// The table at the beginning of a text; `None` if no head names the columns, or the rows are no frames.
pub(in super::super) fn infer(head: &[u8], columns: Option<&Columns>) -> Result<Option<Table>, Question> {
    let mut lines = head_lines(head).map(|(line, _)| line).take(LINES);
    let Some(mut table) = lines.find_map(Table::by_head) else { return Ok(None) };
    let rows: Vec<_> = lines.filter(|line| !line.trim_ascii().is_empty()).collect();
    if !rows.iter().any(|row| table.has_time(row)) {
        table.forget_times();
    }
    let bytes = table.infer_bytes(&rows, columns);
    let id = table.infer_id(&rows, columns);
    let read = table.count(&rows);
    if read == 0 || 2 * read < rows.len() || table.is_of_something_else(&rows) {
        return Ok(None);
    }
    bytes?;
    id?;
    table.find_unit(&rows, columns)?;
    table.find_order(&rows, columns)?;
    Ok(Some(table))
}

/// The question with two readings that differ in the detail of one column. Details that are given are kept.
fn question(readings: [&str; 2], given: Option<&Columns>, column: &str, details: [&str; 2]) -> Question {
    let columns = details.map(|detail| {
        let named = ["date", "time", "id", "data"].map(|name| {
            let detail = if name == column { detail } else { given.map_or("", |given| given.detail(name)) };
            match (name, detail) {
                ("id" | "data", "") => name.to_owned(),
                (_, "") => String::new(),
                _ => format!("{name}[{detail}]"),
            }
        });
        named.into_iter().filter(|column| !column.is_empty()).collect::<Vec<_>>().join(",")
    });
    Question::new(readings[0], readings[1], columns)
}

impl Table {
    /// Number of rows that are frames.
    fn count(&self, rows: &[&[u8]]) -> usize {
        rows.iter().filter(|row| self.row(row).is_ok()).count()
    }

    /// The filled fields of one kind.
    fn texts<'a>(&self, rows: &[&'a [u8]], wanted: fn(Field) -> bool) -> Vec<&'a [u8]> {
        let fields = |row: &&'a [u8]| split(row, self.separator).zip(&self.fields).collect::<Vec<_>>();
        let texts = rows.iter().flat_map(fields).filter(|(_, field)| wanted(**field)).map(|(text, _)| trim(text));
        texts.filter(|text| !text.is_empty()).collect()
    }

    fn has_time(&self, row: &[u8]) -> bool {
        let times = self.texts(&[row], |field| matches!(field, Field::Time(_) | Field::Date));
        times.into_iter().any(is_time)
    }

    /// Times in no known form are no columns.
    fn forget_times(&mut self) {
        for field in &mut self.fields {
            if matches!(field, Field::Time(_) | Field::Date) {
                *field = Field::Other;
            }
        }
    }

    /// Whether nothing but the numbers of bytes says that the rows are frames: other tables have sizes and data too, and
    /// their numbers are decimal.
    fn is_of_something_else(&self, rows: &[&[u8]]) -> bool {
        let is_about_frames = |field: &Field| {
            matches!(field, Field::Length | Field::Extended | Field::Direction | Field::Kind | Field::Channel)
        };
        let is_hex = |text: &&[u8]| text.iter().any(|byte| byte.is_ascii_hexdigit() && !byte.is_ascii_digit());
        let has_hex = self.texts(rows, |field| matches!(field, Field::Data | Field::Byte)).iter().any(is_hex);
        !has_hex && !self.fields.iter().any(is_about_frames)
    }

    /// Finds out whether the bytes are decimal.
    fn infer_bytes(&mut self, rows: &[&[u8]], columns: Option<&Columns>) -> Result<(), Question> {
        let texts = self.texts(rows, |field| matches!(field, Field::Data | Field::Byte));
        let is_between = |byte: &u8| matches!(byte, b' ' | b'-' | b'.' | b'[' | b']');
        let words = || texts.iter().flat_map(|text| text.split(is_between)).filter(|word| !word.is_empty());
        let is_number = |word: &[u8]| word.len() <= 3 && word.iter().all(u8::is_ascii_digit);
        if let Some(radix) = columns.and_then(Columns::data) {
            self.bytes_are_decimal = radix == Radix::Decimal;
            return Ok(());
        }
        if !words().all(is_number) {
            return Ok(());
        }
        let (longest, shortest) = (words().map(<[u8]>::len).max(), words().map(<[u8]>::len).min());
        let is_filled = |word: &[u8]| word.len() == 2 && word.starts_with(b"0");
        match (longest, shortest) {
            (Some(3), _) => self.bytes_are_decimal = true,
            (_, Some(1)) if !words().any(is_filled) => {
                return Err(question(["bytes in hex", "bytes in decimal"], columns, "data", ["hex", "dec"]));
            }
            _ => {}
        }
        Ok(())
    }

    /// Finds out whether the identifiers are decimal.
    fn infer_id(&mut self, rows: &[&[u8]], columns: Option<&Columns>) -> Result<(), Question> {
        let in_head = self.fields.iter().find_map(|field| if let Field::Id(radix) = field { *radix } else { None });
        let given = match columns.map(Columns::id) {
            Some(IdForm::Decimal) => Some(Radix::Decimal),
            Some(IdForm::Hexadecimal | IdForm::Bits11 | IdForm::Bits29) => Some(Radix::Hexadecimal),
            Some(IdForm::Usual) | None => None,
        };
        if let Some(radix) = given.or(in_head) {
            self.id_is_decimal = radix == Radix::Decimal;
            return Ok(());
        }
        let ids = self.texts(rows, |field| matches!(field, Field::Id(_)));
        let decimal = Self { id_is_decimal: true, ..self.clone() };
        let (hex, other) = (self.count(rows), decimal.count(rows));
        // As hexadecimal numbers these would have more than 11 bits, and fewer digits than 29 bits have.
        let is_long = |id: &&[u8]| id.len() == 4 && **id >= *b"0800".as_slice();
        let is_decimal = |id: &&[u8]| id.iter().all(u8::is_ascii_digit) && id.len() <= 4;
        let are_long = ids.iter().any(is_long) && ids.iter().all(is_decimal);
        match () {
            () if other > hex => self.id_is_decimal = true,
            () if other == hex && hex > 0 && are_long && decimal.are_standard(rows) => {
                return Err(question(["identifiers in hex", "identifiers in decimal"], columns, "id", ["hex", "dec"]));
            }
            () => {}
        }
        Ok(())
    }

    fn are_standard(&self, rows: &[&[u8]]) -> bool {
        let id = |row: &&[u8]| self.row(row).ok().map(|row| row.record.frame.id().raw());
        rows.iter().filter_map(id).all(|id| id <= CanId::MAX_STANDARD)
    }

    /// Finds the order of day and month in dates with slashes.
    fn find_order(&mut self, rows: &[&[u8]], columns: Option<&Columns>) -> Result<(), Question> {
        let dates = self.texts(rows, |field| matches!(field, Field::Date | Field::Time(_)));
        let has_slashes = |date: &&&[u8]| date.iter().position(|byte| *byte == b'/').is_some_and(|digits| digits <= 2);
        let mut dates = dates.iter().filter(has_slashes).peekable();
        if dates.peek().is_none() {
            return Ok(());
        }
        let given = columns.and_then(Columns::month_first);
        self.month_first = given.or_else(|| dates.find_map(|date| order(date))).ok_or_else(|| {
            let readings = ["dates that begin with the month", "dates that begin with the day"];
            question(readings, columns, "date", ["mdy", "dmy"])
        })?;
        Ok(())
    }

    /// Finds the unit of the times.
    fn find_unit(&mut self, rows: &[&[u8]], columns: Option<&Columns>) -> Result<(), Question> {
        let in_head = self.fields.iter().find_map(|field| if let Field::Time(unit) = field { *unit } else { None });
        // SavvyCAN's GVRET files count microseconds.
        let is_gvret = self.fields.contains(&Field::Byte) && self.fields.contains(&Field::Extended);
        if let Some(unit) = columns.and_then(Columns::unit).or(in_head).or(is_gvret.then_some(Unit::Micros)) {
            self.unit = unit;
            return Ok(());
        }
        let times: Vec<_> =
            rows.iter().filter_map(|row| self.row(row).ok()).filter_map(|row| plain(row.time)).collect();
        match units(&times)[..] {
            [first, second, ..] => {
                let [one, other] = [first, second].map(|unit| format!("times in {}", unit.symbol()));
                Err(question([&one, &other], columns, "time", [first, second].map(Unit::symbol)))
            }
            [unit] => {
                self.unit = unit;
                Ok(())
            }
            [] => Ok(()),
        }
    }
}
