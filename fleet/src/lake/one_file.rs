//! Puts one file into the lake; the file is read once, for all tables.

use super::parquet::{Folder, ParquetFile};
use super::{Entry, Location, Part, Span, part_name};
use crate::capture::{CaptureFile, Reading, Seen, Unreadable};
use crate::scan::diagnosed::{self, Diagnosing};
use crate::scan::emit::{Emitter, Wanted};
use crate::scan::results;
use crate::scan::rows::{self, DecodedFrame};
use crate::scan::{ScanError, Source, capture_row, unreadable_row};
use crate::table::Table;
use crate::table::captures::Captures;
use crate::table::column::{Rows, nanos};
use crate::table::events::Events;
use canvass_tables::event_collector::EventCollector;
use canvass_traces::Timestamp;
use datafusion::arrow::datatypes::SchemaRef;
use tokio::runtime::Handle;

/// Number of rows in a batch.
const BATCH: usize = 8192;

/// Puts files into a lake.
pub struct Ingester<'a> {
    /// The access to source files, with the rules of devices.
    pub source: Source<'a>,
    /// The lake.
    pub location: &'a Location,
    /// The rules by which files are read, from `entry::rules`.
    pub rules: &'a str,
    /// The runtime for asynchronous writes.
    pub handle: Handle,
}

/// All columns of a table.
struct Whole {
    columns: Vec<usize>,
    schema: SchemaRef,
}

impl Whole {
    fn new(table: Table) -> Self {
        let schema = table.schema();
        Self { columns: (0..schema.fields().len()).collect(), schema }
    }

    fn wanted(&self) -> Wanted<'_> {
        Wanted {
            columns: &self.columns,
            schema: &self.schema,
            tests: &[],
            fetch: None,
            skips: false,
            batch_rows: BATCH,
        }
    }
}

impl Ingester<'_> {
    /// Puts a file into the lake. The entry of an unreadable file tells the reason.
    ///
    /// # Errors
    /// [`ScanError`] if the lake can't be written or a device description can't be read.
    pub fn ingest(&self, file: &CaptureFile) -> Result<Entry, ScanError> {
        match self.result(file) {
            Ok(Some(entry)) => return Ok(entry),
            Ok(None) => {}
            Err(failed) => return self.unread(file, failed),
        }
        match Reading::open(self.source.access, file, true) {
            Ok(Ok(reading)) => self.capture(file, reading).or_else(|failed| self.unread(file, failed)),
            Ok(Err(unreadable)) => self.no_capture(file, &unreadable),
            Err(failed) => self.unread(file, failed.into()),
        }
    }

    fn folder(&self, file: &CaptureFile, begin: Option<Timestamp>) -> Folder {
        let name = part_name(file, self.rules);
        Folder { location: self.location.clone(), name, begin, handle: self.handle.clone() }
    }

    fn entry(&self, file: &CaptureFile, sha256: String) -> Entry {
        let rules = self.rules.to_owned();
        Entry { file: file.clone(), rules, sha256, span: None, copy_of: None, reason: None, parts: Vec::new() }
    }

    /// The entry of a file that could not be read: the file is listed, and the next run tries again.
    fn unread(&self, file: &CaptureFile, failed: ScanError) -> Result<Entry, ScanError> {
        let ScanError::Access(failed) = failed else { return Err(failed) };
        let mut entry = self.no_capture(file, &Unreadable { reason: failed.to_string(), sha256: None })?;
        entry.sha256.clear();
        Ok(entry)
    }

    /// The entry of a file that is of no known format.
    fn no_capture(&self, file: &CaptureFile, unreadable: &Unreadable) -> Result<Entry, ScanError> {
        let part = self.table::<Captures>(Table::Captures, &self.folder(file, None), |emitter| {
            unreadable_row(file, unreadable, |row| emitter.row(row)).map(|_| ())
        })?;
        let mut entry = self.entry(file, unreadable.sha256.clone().unwrap_or_default());
        entry.reason = Some(unreadable.reason.clone());
        entry.parts.extend(part);
        Ok(entry)
    }

    /// Ingests a result of `canvass test` or `fuzz`; `None` if the file is no such result.
    fn result(&self, file: &CaptureFile) -> Result<Option<Entry>, ScanError> {
        if !file.name.ends_with(".json") || file.size > results::LONGEST {
            return Ok(None);
        }
        let (content, sha256) = self.source.access.read(file, results::LONGEST)?;
        let Some(document) = results::read(&content) else { return Ok(None) };
        let begin = results::date(&document);
        let mut entry = self.entry(file, sha256);
        for table in [Table::Runs, Table::Verdicts] {
            let (whole, mut parquet) = (Whole::new(table), ParquetFile::new(&self.folder(file, begin), table));
            results::give(&document, &entry.sha256, table, file, whole.wanted(), &mut parquet)?;
            entry.parts.extend(parquet.finish()?);
        }
        entry.span = begin.map(|begin| (nanos(begin), nanos(begin)));
        Ok(Some(entry))
    }

    fn table<R: Rows>(
        &self,
        table: Table,
        folder: &Folder,
        give: impl FnOnce(&mut Emitter<'_, R>) -> Result<(), ScanError>,
    ) -> Result<Option<Part>, ScanError> {
        let (whole, mut parquet) = (Whole::new(table), ParquetFile::new(folder, table));
        let mut emitter = Emitter::new(whole.wanted(), &mut parquet);
        give(&mut emitter)?;
        emitter.finish()?;
        parquet.finish()
    }

    fn capture(&self, file: &CaptureFile, mut reading: Reading) -> Result<Entry, ScanError> {
        // The date of the first frame determines the folder.
        let mut seen = reading.advance()?;
        let mut is_damaged = false;
        while seen == Some(Seen::Damage) {
            (seen, is_damaged) = (reading.advance()?, true);
        }
        let begin = seen.map(|_| reading.record().timestamp);
        let folder = self.folder(file, begin);
        let mut diagnosing = Diagnosing::new(self.source.devices)?;
        if is_damaged {
            diagnosing.take(Seen::Damage, &mut reading)?;
        }
        let (mut parts, span) = self.frames(file, &mut reading, seen, &folder, &mut diagnosing)?;
        let found = diagnosing.finish(&reading)?;
        for table in [Table::Findings, Table::Nodes, Table::Statistics] {
            let (whole, mut parquet) = (Whole::new(table), ParquetFile::new(&folder, table));
            diagnosed::give(table, &found, &reading, file, whole.wanted(), &mut parquet)?;
            parts.extend(parquet.finish()?);
        }
        let sha256 = reading.sha256(self.source.access, file)?;
        parts.extend(self.table::<Captures>(Table::Captures, &folder, |emitter| {
            emitter.row(&capture_row(file, &reading, sha256.as_deref())).map(|_| ())
        })?);
        let reason = reading.stopped().map(str::to_owned);
        Ok(Entry { span, reason, parts, ..self.entry(file, sha256.unwrap_or_default()) })
    }

    /// Writes the tables with rows for frames; `seen` is the first item, which was read already. Returns the first and
    /// the last time of all rows, too: salvaged frames and those of a clock that was set may have any.
    fn frames(
        &self,
        file: &CaptureFile,
        reading: &mut Reading,
        mut seen: Option<Seen>,
        folder: &Folder,
        diagnosing: &mut Diagnosing,
    ) -> Result<(Vec<Part>, Option<Span>), ScanError> {
        let mut span: Option<Span> = None;
        let wholes = [Table::Messages, Table::Signals, Table::Events].map(Whole::new);
        let [mut messages, mut signals, mut events] =
            [Table::Messages, Table::Signals, Table::Events].map(|table| ParquetFile::new(folder, table));
        let mut to_messages = Emitter::new(wholes[0].wanted(), &mut messages);
        let mut to_signals = Emitter::new(wholes[1].wanted(), &mut signals);
        let mut to_events = Emitter::<Events>::new(wholes[2].wanted(), &mut events);
        let (mut network, mut collector) = (rows::network(self.source.devices)?, EventCollector::default());
        while let Some(what) = seen {
            if what != Seen::Damage {
                let (record, channels) = (reading.record(), reading.merge().channels());
                let now = nanos(record.timestamp);
                span = Some(span.map_or((now, now), |(first, last)| (first.min(now), last.max(now))));
                let decoded = &network.handle(record);
                if let Some(bus) = network.bus(record.channel) {
                    let frame = DecodedFrame { capture: &file.name, record, channels, decoded, bus };
                    // An error of writing is reported when the file is finished.
                    let _ = rows::message(frame, &mut to_messages)?;
                    let _ = rows::signals(frame, &mut to_signals)?;
                    let _ = collector.frame(frame, |row| to_events.row(row))?;
                }
            }
            diagnosing.take(what, reading)?;
            seen = reading.advance()?;
        }
        let channels = reading.merge().channels();
        collector.finish(&file.name, channels, &network, None, |row| to_events.row(row))?;
        to_messages.finish()?;
        to_signals.finish()?;
        to_events.finish()?;
        let finished = [messages.finish()?, signals.finish()?, events.finish()?];
        Ok((finished.into_iter().flatten().collect(), span))
    }
}
