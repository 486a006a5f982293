//! The program's outputs for captures, as downloads: the files are read again, a piece at a time.

use crate::descriptions::Described;
use crate::file::ChosenFile;
use crate::input::{Input, InputOptions, Next};
use crate::opening;
use canvass_analyzer::Meaning;
use canvass_analyzer::filter::{Filter, Subject};
use canvass_analyzer::network::{Decoded, Network};
use canvass_reports::decode::{CsvLines, JsonLines, Line, Lines, TableLines, TextLines, TimeStyle};
use canvass_reports::events::{Events, JsonEvents, Scene, TextEvents};
use canvass_reports::signals::{CsvSheet, JsonSheet, Sampler, Sheet};
use canvass_traces::{
    ChannelId, Compression, Duration, Format, OpenError, Record, Recording, Timestamp, WriteError, WriteOptions, Writer,
};
use std::cell::RefCell;
use std::io::{self, Cursor, Write};
use std::rc::Rc;

/// The requested export.
#[derive(Clone, Debug, Default, serde::Deserialize)]
#[serde(default)]
pub struct Wish {
    /// The kind of output: `decode`, `events`, `signals` or `convert`.
    pub what: String,
    /// The format: `text`, `table`, `json` or `csv`; for `convert` the id of a format.
    pub format: String,
    /// A filter of frames; empty: all frames.
    pub filter: String,
    /// Whether to compress by gzip; for `convert` only.
    pub gzip: bool,
    /// Interval of rows in nanoseconds, for `signals`.
    pub every: Option<u64>,
}

/// Why an export can't be made.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A capture can't be opened.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The filter is wrong.
    #[error(transparent)]
    Filter(#[from] canvass_analyzer::filter::FilterError),
    /// The capture can't be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The kind of export is unknown, or not available in this format.
    #[error("no export: {what} as {format}")]
    Unknown {
        /// The requested kind of export.
        what: String,
        /// The requested format.
        format: String,
    },
    /// Another error.
    #[error(transparent)]
    Io(#[from] io::Error),
}

/// An export in progress.
pub struct Export {
    input: Input,
    network: Network,
    filter: Option<Filter>,
    form: Form,
    comment: String,
    last: Option<Timestamp>,
    /// Whether all captures were read; the rest of the output may still have to be written.
    ended: bool,
}

enum Form {
    Lines(Box<dyn Lines>, bool),
    Events(Box<dyn Events>),
    Signals(Box<Sampler>, Box<dyn Sheet>),
    Convert { format: Format, compression: Compression, recording: Option<Recording>, written: Written },
}

/// The output that a recording has written.
#[derive(Clone, Default)]
struct Written(Rc<RefCell<Vec<u8>>>);

impl Write for Written {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Form {
    fn of(wish: &Wish) -> Option<Self> {
        let time = TimeStyle::Absolute;
        Some(match (&*wish.what, &*wish.format) {
            ("decode", "text") => Self::Lines(Box::new(TextLines::new(time, false)), false),
            ("decode", "table") => Self::Lines(Box::new(TableLines::new(time, false, None)), false),
            ("decode", "json") => Self::Lines(Box::new(JsonLines::new()), false),
            ("decode", "csv") => Self::Lines(Box::new(CsvLines::new(time)), false),
            ("events", "text") => Self::Events(Box::new(TextEvents::new(time, false))),
            ("events", "json") => Self::Events(Box::new(JsonEvents::new())),
            ("signals", "csv" | "json") => {
                let by_pdo = wish.every.is_none();
                let sheet: Box<dyn Sheet> = match &*wish.format {
                    "csv" => Box::new(CsvSheet::new(Cursor::new(Vec::new()), by_pdo)),
                    _ => Box::new(JsonSheet::new()),
                };
                Self::Signals(Box::new(Sampler::new(wish.every.map(Duration))), sheet)
            }
            ("convert", id) => {
                let compression = if wish.gzip { Compression::Gzip } else { Compression::None };
                let format = Format::by_id(id).filter(|format| format.is_written())?;
                Self::Convert { format, compression, recording: None, written: Written::default() }
            }
            _ => return None,
        })
    }
}

impl Export {
    /// Begins an export.
    ///
    /// # Errors
    /// [`ExportError`] if a capture can't be opened, or the filter or format is wrong.
    pub fn begin(
        files: &[ChosenFile],
        options: &InputOptions,
        described: &[Described],
        wish: &Wish,
    ) -> Result<Self, ExportError> {
        let unknown = || ExportError::Unknown { what: wish.what.clone(), format: wish.format.clone() };
        let form = Form::of(wish).ok_or_else(unknown)?;
        let filter = if wish.filter.trim().is_empty() { None } else { Some(wish.filter.parse()?) };
        let input = Input::open(files, options, false)?;
        let network = opening::network(described);
        Ok(Self { input, network, filter, form, comment: String::new(), last: None, ended: false })
    }

    /// The captures.
    pub const fn input(&self) -> &Input {
        &self.input
    }

    /// Reads the next `records` records, and appends the exported frames to `out`; `false` when everything is written.
    ///
    /// # Errors
    /// [`ExportError`] if the output can't be written.
    pub fn step(&mut self, records: usize, out: &mut Vec<u8>) -> Result<bool, ExportError> {
        if self.ended {
            return Ok(self.rest(out)?);
        }
        for _ in 0..records {
            match self.input.advance() {
                Some(Next::Record(record)) => self.take(&record, true, out)?,
                Some(Next::Salvaged(record)) => self.take(&record, false, out)?,
                Some(Next::Damage) => {}
                None => {
                    self.ended = true;
                    self.end(out)?;
                    return Ok(true);
                }
            }
        }
        self.hand_over(out);
        Ok(true)
    }

    fn take(&mut self, record: &Record, whole: bool, out: &mut Vec<u8>) -> Result<(), ExportError> {
        if let Some(latest) = record.comment() {
            self.comment.clear();
            self.comment.push_str(latest);
        }
        let decoded = self.network.handle(record);
        self.last = Some(record.timestamp);
        let channels = self.input.merge().channels();
        let subject = Subject { record, decoded: &decoded, channel: channels.name(record.channel) };
        if self.filter.as_ref().is_none_or(|filter| filter.matches(&subject)) {
            self.put(record, &decoded, whole, out)?;
        }
        Ok(())
    }

    fn put(&mut self, record: &Record, decoded: &Decoded, whole: bool, out: &mut Vec<u8>) -> Result<(), ExportError> {
        let Some(bus) = self.network.bus(record.channel) else { return Ok(()) };
        let (channels, comment) = (self.input.merge().channels(), &mut self.comment);
        match &mut self.form {
            Form::Lines(lines, begun) => {
                if !std::mem::replace(begun, true) {
                    lines.begin(out);
                }
                if !comment.is_empty() {
                    lines.comment(comment, out);
                    comment.clear();
                }
                lines.line(&Line { record, channels, decoded, meaning: Meaning::new(record, decoded, bus) }, out);
            }
            Form::Events(events) => {
                let channel = channels.name(record.channel);
                let scene = Scene { time: record.timestamp, channel, bus, frame: Some((record, decoded)) };
                for event in bus.events() {
                    if !comment.is_empty() {
                        events.comment(&scene, comment, out);
                        comment.clear();
                    }
                    events.event(&scene, event, out);
                }
            }
            Form::Signals(sampler, sheet) => {
                let meaning = Meaning::new(record, decoded, bus);
                sampler.frame(record, channels, decoded, &meaning, sheet.as_mut(), out)?;
            }
            // A salvaged frame contradicts itself; in the output it would look like a good frame.
            Form::Convert { .. } if !whole => {}
            Form::Convert { format, compression, recording, written } => {
                let options = WriteOptions { time_base: self.input.merge().time_base(), ..WriteOptions::default() };
                let recording = match recording {
                    Some(recording) => recording,
                    None => {
                        recording.insert(Recording::create(Box::new(written.clone()), *format, *compression, &options)?)
                    }
                };
                recording.write(record, channels)?;
            }
        }
        Ok(())
    }

    /// Ends the export after the last record.
    fn end(&mut self, out: &mut Vec<u8>) -> Result<(), ExportError> {
        match &mut self.form {
            Form::Lines(lines, false) => lines.begin(out),
            Form::Lines(..) => {}
            Form::Events(events) => {
                // A filter selects frames; an event at the end of the capture belongs to no frame.
                if let (Some(last), None) = (self.last, &self.filter) {
                    open_transfers(&self.input, &self.network, last, events.as_mut(), out);
                }
            }
            Form::Signals(sampler, sheet) => sampler.finish(sheet.as_mut(), out)?,
            Form::Convert { recording, .. } => {
                if let Some(mut recording) = recording.take() {
                    recording.finish()?;
                }
            }
        }
        self.hand_over(out);
        Ok(())
    }

    /// Writes the rest of the output, which needs the end of the captures.
    fn rest(&mut self, out: &mut Vec<u8>) -> io::Result<bool> {
        match &mut self.form {
            Form::Signals(sampler, sheet) => sheet.finish(sampler.columns(), out),
            _ => Ok(false),
        }
    }

    fn hand_over(&mut self, out: &mut Vec<u8>) {
        if let Form::Convert { written, .. } = &self.form {
            out.append(&mut written.0.borrow_mut());
        }
    }
}

fn open_transfers(input: &Input, network: &Network, time: Timestamp, events: &mut dyn Events, out: &mut Vec<u8>) {
    for (id, channel) in (0_u16..).zip(input.merge().channels().names()) {
        let Some(bus) = network.bus(ChannelId(id)) else { continue };
        let scene = Scene { time, channel, bus, frame: None };
        for (server, transfer) in bus.open_transfers() {
            events.open_transfer(&scene, server, transfer, out);
        }
    }
}
