//! Reads SQLite databases: the whole file into memory, then the rows of the table of messages in their order.

use super::message::{Places, message, places};
use super::pages::{Pages, Walk};
use super::row::{Value, columns};
use crate::damage::Flaw;
use crate::formats::python_can::{CHANNEL, time_base};
use crate::{Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, TimeBase};
use std::io::Read;

const SIGNATURE: &[u8] = b"SQLite format 3\0";
/// Limit of the size of a file in bytes: 1 GiB.
const LARGEST: u64 = 1 << 30;
/// The page of the table of all tables.
const SCHEMA: u32 = 1;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head.starts_with(SIGNATURE)
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(SqliteReader {
        source: Some(source),
        table: None,
        failed: None,
        channels: Channels::new(),
        base: None,
        number: 0,
        last_row: None,
        held: None,
    })
}

struct SqliteReader {
    /// The file; `None` once it was read.
    source: Option<Source>,
    table: Option<Table>,
    /// An error of the source, which is reported after the rows that it left.
    failed: Option<Damage>,
    channels: Channels,
    base: Option<TimeBase>,
    number: u64,
    /// The number of the row of the last message.
    last_row: Option<u64>,
    /// A message that comes after the damage before it.
    held: Option<Record>,
}

/// The table of messages.
struct Table {
    pages: Pages,
    walk: Walk,
    places: Places,
}

/// The offset of a page, and the message of a row with the number of the row.
type Found = (u64, Result<(u64, Record), Flaw>);

impl Table {
    fn find(file: Vec<u8>) -> Result<Self, Flaw> {
        let pages = Pages::new(file)?;
        let mut tables = Walk::new(&pages, SCHEMA);
        while let Some(row) = tables.next(&pages) {
            let row = row?;
            // Type, name, name of the table, first page, SQL.
            let [.., Value::Integer(root), Value::Text(sql)] = columns(&row.bytes)?[..] else { continue };
            let places = str::from_utf8(sql).ok().and_then(places);
            if let (Some(places), Ok(root)) = (places, u32::try_from(root)) {
                let walk = Walk::new(&pages, root);
                return Ok(Self { pages, walk, places });
            }
        }
        Err(Flaw::malformed(
            "a table with the columns ts, arbitration_id, extended, remote, error, dlc and data",
            "none",
        ))
    }

    /// The next message with the number of its row, and the offset of its page.
    fn next(&mut self) -> Option<Found> {
        let offset = self.pages.offset(self.walk.page());
        let row = self.walk.next(&self.pages)?;
        let offset = if row.is_ok() { self.pages.offset(self.walk.page()) } else { offset };
        let record = row.and_then(|row| {
            let record = columns(&row.bytes).and_then(|columns| message(&columns, &self.places))?;
            Ok((row.number, record))
        });
        Some((offset, record))
    }
}

impl SqliteReader {
    fn load(&mut self, mut source: Source) -> Result<(), Damage> {
        let mut file = Vec::new();
        let read = (&mut source).take(LARGEST + 1).read_to_end(&mut file);
        let place = Place { number: 0, offset: file.len() as u64 };
        if file.len() as u64 > LARGEST {
            let expected = format!("a file of at most {LARGEST} bytes");
            return Err(Damage::new(DamageKind::Fatal, place, expected, b"more"));
        }
        self.failed = read.err().map(|error| Damage::source(&error.into(), place));
        let table = Table::find(file);
        let fatal = |flaw: Flaw| Damage { kind: DamageKind::Fatal, ..flaw.damage(Place::default()) };
        self.table = Some(table.map_err(fatal)?);
        Ok(())
    }
}

impl SqliteReader {
    /// What is reported after the last message: an error of the source, or that pages are missing.
    fn end(&mut self) -> Option<Result<Record, Damage>> {
        let missing = self.table.take().and_then(|table| {
            let place = Place { number: self.number, offset: table.pages.length() };
            let expected = format!("a file of {} pages, as its header says", table.pages.missing()?);
            Some(Damage::new(DamageKind::Unfinished, place, expected, table.pages.length().to_string().as_bytes()))
        });
        self.failed.take().or(missing).map(Err)
    }
}

impl Iterator for SqliteReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(source) = self.source.take()
            && let Err(damage) = self.load(source)
        {
            return Some(Err(damage));
        }
        if let Some(record) = self.held.take() {
            return Some(Ok(record));
        }
        let next = self.table.as_mut().and_then(Table::next);
        let Some((offset, row)) = next else { return self.end() };
        self.number += 1;
        let place = Place { number: self.number, offset };
        let (row, mut record) = match row {
            Ok(found) => found,
            Err(flaw) => {
                // The damage tells of the row.
                self.last_row = self.last_row.map(|last| last + 1);
                return Some(Err(flaw.damage(place)));
            }
        };
        self.base.get_or_insert(time_base(record.timestamp));
        record.channel = self.channels.intern(CHANNEL);
        record.place = place;
        let lost = self.last_row.map_or(0, |last| row.saturating_sub(last).saturating_sub(1));
        self.last_row = Some(row);
        if lost == 0 {
            return Some(Ok(record));
        }
        self.held = Some(record);
        Some(Err(Damage::dropped(lost, place)))
    }
}

impl Reader for SqliteReader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        self.base.unwrap_or_default()
    }
}
