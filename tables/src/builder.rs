//! Builds Arrow batches from rows, with only the requested columns.

use super::column::{Column, Get, Rows, Width, nanos};
use arrow_array::builder::{
    BinaryBuilder, BooleanBuilder, Float64Builder, Int32Builder, Int64Builder, StringBuilder,
    TimestampNanosecondBuilder, UInt8Builder, UInt16Builder, UInt32Builder, UInt64Builder,
};
use arrow_array::types::Int32Type;
use arrow_array::{ArrayRef, DictionaryArray, RecordBatch, RecordBatchOptions, StringArray};
use arrow_buffer::{Buffer, NullBufferBuilder, OffsetBuffer};
use arrow_schema::{ArrowError, SchemaRef};
use std::collections::HashMap;
use std::sync::Arc;

/// Builds batches of the requested columns.
pub struct BatchBuilder<R: Rows> {
    schema: SchemaRef,
    cells: Vec<(Get<R>, Cell)>,
    rows: usize,
    /// Number of bytes of texts and payloads in the batch, which can be long.
    bytes: usize,
    scratch: String,
}

/// One column of the current batch.
enum Cell {
    Time(TimestampNanosecondBuilder),
    U8(UInt8Builder),
    U16(UInt16Builder),
    U32(UInt32Builder),
    U64(UInt64Builder),
    Signed(Int64Builder),
    Real(Float64Builder),
    Flag(BooleanBuilder),
    Name(Names),
    Text(Texts),
    Bytes(BinaryBuilder),
}

impl<R: Rows> BatchBuilder<R> {
    /// Number of bytes of texts and payloads at which a batch is full, whatever its number of rows.
    const FULL: usize = 4 << 20;

    /// A builder of these columns, whose types `schema` gives.
    pub fn new(schema: SchemaRef, columns: &[usize]) -> Self {
        let chosen = columns.iter().filter_map(|&at| R::COLUMNS.get(at));
        let cells = chosen.map(|Column { get, .. }| (*get, Cell::of(get))).collect();
        Self { schema, cells, rows: 0, bytes: 0, scratch: String::new() }
    }

    /// Number of rows in the current batch.
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Whether the batch is full: by its number of rows or its bytes.
    pub const fn is_full(&self, most: usize) -> bool {
        self.rows >= most || self.bytes >= Self::FULL
    }

    /// Adds a row.
    pub fn push(&mut self, row: &R::Row<'_>) {
        self.rows += 1;
        for (get, cell) in &mut self.cells {
            self.bytes += push(get, cell, row, &mut self.scratch);
        }
    }

    /// Returns the rows since the last call as a batch.
    ///
    /// # Errors
    /// If Arrow refuses the columns, which would be a bug of this module.
    pub fn finish(&mut self) -> Result<RecordBatch, ArrowError> {
        let rows = std::mem::take(&mut self.rows);
        self.bytes = 0;
        let arrays = self.cells.iter_mut().map(|(_, cell)| cell.finish()).collect::<Result<_, _>>()?;
        let options = RecordBatchOptions::new().with_row_count(Some(rows));
        RecordBatch::try_new_with_options(Arc::clone(&self.schema), arrays, &options)
    }
}

/// Appends the value of a row; returns the number of bytes of its text or payload.
fn push<R: Rows>(get: &Get<R>, cell: &mut Cell, row: &R::Row<'_>, scratch: &mut String) -> usize {
    match (get, cell) {
        (Get::Time(get), Cell::Time(cell)) => cell.append_option(get(row).map(nanos)),
        (Get::Unsigned(_, get), Cell::U8(cell)) => cell.append_option(get(row).map(|value| value as u8)),
        (Get::Unsigned(_, get), Cell::U16(cell)) => cell.append_option(get(row).map(|value| value as u16)),
        (Get::Unsigned(_, get), Cell::U32(cell)) => cell.append_option(get(row).map(|value| value as u32)),
        (Get::Unsigned(_, get), Cell::U64(cell)) => cell.append_option(get(row)),
        (Get::Signed(get), Cell::Signed(cell)) => cell.append_option(get(row)),
        (Get::Real(get), Cell::Real(cell)) => cell.append_option(get(row)),
        (Get::Flag(get), Cell::Flag(cell)) => cell.append_option(get(row)),
        (Get::Word(get), Cell::Name(names)) => names.word(get(row)),
        (Get::Name(write), Cell::Name(names)) => {
            scratch.clear();
            let is_there = write(row, scratch);
            names.name(is_there.then_some(scratch.as_str()));
        }
        (Get::Text(write), Cell::Text(texts)) => return texts.append(|text| write(row, text)),
        (Get::Bytes(get), Cell::Bytes(cell)) => {
            let bytes = get(row);
            cell.append_option(bytes);
            return bytes.map_or(0, <[u8]>::len);
        }
        // `Cell::of` makes the cell that fits a getter, so that other pairs can't occur.
        _ => {}
    }
    0
}

impl Cell {
    fn of<R: Rows>(get: &Get<R>) -> Self {
        match get {
            Get::Time(_) => Self::Time(TimestampNanosecondBuilder::new().with_timezone("UTC")),
            Get::Unsigned(Width::U8, _) => Self::U8(UInt8Builder::new()),
            Get::Unsigned(Width::U16, _) => Self::U16(UInt16Builder::new()),
            Get::Unsigned(Width::U32, _) => Self::U32(UInt32Builder::new()),
            Get::Unsigned(Width::U64, _) => Self::U64(UInt64Builder::new()),
            Get::Signed(_) => Self::Signed(Int64Builder::new()),
            Get::Real(_) => Self::Real(Float64Builder::new()),
            Get::Flag(_) => Self::Flag(BooleanBuilder::new()),
            Get::Word(_) | Get::Name(_) => Self::Name(Names::default()),
            Get::Text(_) => Self::Text(Texts::default()),
            Get::Bytes(_) => Self::Bytes(BinaryBuilder::new()),
        }
    }

    fn finish(&mut self) -> Result<ArrayRef, ArrowError> {
        Ok(match self {
            Self::Time(cell) => Arc::new(cell.finish()),
            Self::U8(cell) => Arc::new(cell.finish()),
            Self::U16(cell) => Arc::new(cell.finish()),
            Self::U32(cell) => Arc::new(cell.finish()),
            Self::U64(cell) => Arc::new(cell.finish()),
            Self::Signed(cell) => Arc::new(cell.finish()),
            Self::Real(cell) => Arc::new(cell.finish()),
            Self::Flag(cell) => Arc::new(cell.finish()),
            Self::Name(names) => return names.finish(),
            Self::Text(texts) => return texts.finish(),
            Self::Bytes(cell) => Arc::new(cell.finish()),
        })
    }
}

/// The texts of a column in one buffer, each written at its final place.
struct Texts {
    text: String,
    /// The offset of the beginning of each text, and of the end of the last text.
    offsets: Vec<i32>,
    there: NullBufferBuilder,
}

impl Default for Texts {
    fn default() -> Self {
        Self { text: String::new(), offsets: vec![0], there: NullBufferBuilder::new(0) }
    }
}

impl Texts {
    /// Appends the text that `write` writes, or null if `write` returns `false`; returns the number of bytes.
    fn append(&mut self, write: impl FnOnce(&mut String) -> bool) -> usize {
        let begin = self.text.len();
        let is_there = write(&mut self.text);
        if !is_there {
            self.text.truncate(begin);
        }
        self.there.append(is_there);
        // A batch is full long before the offset exceeds 31 bits.
        self.offsets.push(i32::try_from(self.text.len()).unwrap_or(i32::MAX));
        self.text.len() - begin
    }

    fn finish(&mut self) -> Result<ArrayRef, ArrowError> {
        let capacity = self.text.len();
        let text = std::mem::replace(&mut self.text, String::with_capacity(capacity));
        let rows = self.offsets.len();
        let offsets = std::mem::replace(&mut self.offsets, Vec::with_capacity(rows));
        self.offsets.push(0);
        let (offsets, text) = (OffsetBuffer::new(offsets.into()), Buffer::from(text.into_bytes()));
        Ok(Arc::new(StringArray::try_new(offsets, text, self.there.finish())?))
    }
}

/// A dictionary column. The same name often follows itself, so each name is first compared with the last one.
#[derive(Default)]
struct Names {
    keys: Int32Builder,
    values: StringBuilder,
    known: HashMap<Box<str>, i32>,
    last: Option<(Box<str>, i32)>,
    /// The keys of static strings of the program, found by address and length without comparing characters.
    words: Vec<((usize, usize), i32)>,
}

impl Names {
    fn word(&mut self, word: Option<&'static str>) {
        let Some(word) = word else { return self.keys.append_null() };
        let place = (word.as_ptr().addr(), word.len());
        let known = self.words.iter().find(|known| known.0 == place).map(|known| known.1);
        let key = known.unwrap_or_else(|| {
            let key = self.key(word);
            self.words.push((place, key));
            key
        });
        self.keys.append_value(key);
    }

    fn name(&mut self, name: Option<&str>) {
        let Some(name) = name else { return self.keys.append_null() };
        let key = match &self.last {
            Some((last, key)) if **last == *name => *key,
            _ => {
                let key = self.key(name);
                self.last = Some((name.into(), key));
                key
            }
        };
        self.keys.append_value(key);
    }

    fn key(&mut self, name: &str) -> i32 {
        if let Some(&key) = self.known.get(name) {
            return key;
        }
        // A batch has far fewer rows than there are keys.
        let key = self.known.len() as i32;
        self.values.append_value(name);
        self.known.insert(name.into(), key);
        key
    }

    fn finish(&mut self) -> Result<ArrayRef, ArrowError> {
        let (keys, values) = (self.keys.finish(), self.values.finish());
        self.known.clear();
        self.words.clear();
        self.last = None;
        Ok(Arc::new(DictionaryArray::<Int32Type>::try_new(keys, Arc::new(values))?))
    }
}
