//! The capture formats, one file each, and their table.

pub(crate) mod asc;
mod asc_row;
mod asc_writer;
pub(crate) mod blf;
pub(crate) mod candump_console;
pub(crate) mod candump_log;
mod candump_usual;
mod limits;
pub(crate) mod mcap;
pub(crate) mod minimon;
pub(crate) mod pasted;
pub(crate) mod pcap;
pub(crate) mod pcapng;
pub(crate) mod python_can_csv;
pub(crate) mod socketcan;
pub(crate) mod trc;
mod trc_numbers;
mod trc_row;
mod trc_writer;

use crate::{Format, ReadOptions, Reader, Source, WriteError, WriteOptions, Writer};
use std::io::Write;

/// A format: its detection, reader and writer.
pub(crate) struct FormatEntry {
    format: Format,
    /// Whether a source that begins with these bytes has the format. Gets at most [`Format::SNIFF`] bytes.
    sniff: fn(&[u8]) -> bool,
    open: fn(Source, &ReadOptions) -> Box<dyn Reader>,
    create: Option<Create>,
}

type Create = fn(Box<dyn Write>, &WriteOptions) -> Result<Box<dyn Writer>, WriteError>;

/// The formats in the order of detection: those with a magic number first, free text last.
const FORMATS: &[FormatEntry] = &[
    FormatEntry { format: Format::Pcapng, sniff: pcapng::sniff, open: pcapng::open, create: Some(pcapng::create) },
    FormatEntry { format: Format::Pcap, sniff: pcap::sniff, open: pcap::open, create: Some(pcap::create) },
    FormatEntry { format: Format::Mcap, sniff: mcap::sniff, open: mcap::open, create: Some(mcap::create) },
    FormatEntry { format: Format::Blf, sniff: blf::sniff, open: blf::open, create: None },
    FormatEntry { format: Format::Trc, sniff: trc::sniff, open: trc::open, create: Some(trc::create) },
    FormatEntry {
        format: Format::PythonCanCsv,
        sniff: python_can_csv::sniff,
        open: python_can_csv::open,
        create: Some(python_can_csv::create),
    },
    FormatEntry { format: Format::MiniMon, sniff: minimon::sniff, open: minimon::open, create: None },
    FormatEntry { format: Format::Asc, sniff: asc::sniff, open: asc::open, create: Some(asc::create) },
    FormatEntry {
        format: Format::Candump,
        sniff: candump_log::sniff,
        open: candump_log::open,
        create: Some(candump_log::create),
    },
    FormatEntry {
        format: Format::CandumpConsole,
        sniff: candump_console::sniff,
        open: candump_console::open,
        create: None,
    },
    FormatEntry { format: Format::Pasted, sniff: pasted::sniff, open: pasted::open, create: None },
];

impl Format {
    /// Number of bytes that the detection examines.
    pub const SNIFF: usize = 64 * 1024;

    /// All formats.
    pub fn all() -> impl Iterator<Item = Self> {
        FORMATS.iter().map(|row| row.format)
    }

    /// The format with this id, such as `candump`.
    pub fn by_id(id: &str) -> Option<Self> {
        Self::all().find(|format| format.id() == id)
    }

    /// The format that files with this extension (without the dot) usually have.
    pub fn by_extension(extension: &str) -> Option<Self> {
        let writes = |row: &&FormatEntry| {
            row.create.is_some() && row.format.extensions().iter().any(|e| e.eq_ignore_ascii_case(extension))
        };
        FORMATS.iter().find(writes).map(|row| row.format)
    }

    /// The format of a source that begins with these bytes.
    pub fn sniff(head: &[u8]) -> Option<Self> {
        FORMATS.iter().find(|row| (row.sniff)(head)).map(|row| row.format)
    }

    /// Like [`Format::sniff`], without the format that any lines of frames have: more bytes may show a known format.
    pub(crate) fn sniff_known(head: &[u8]) -> Option<Self> {
        let mut known = FORMATS.iter().filter(|row| row.format != Self::Pasted);
        known.find(|row| (row.sniff)(head)).map(|row| row.format)
    }

    fn row(self) -> &'static FormatEntry {
        let row = FORMATS.iter().find(|row| row.format == self);
        debug_assert!(row.is_some(), "{self} has no row in FORMATS");
        row.unwrap_or(&FORMATS[0])
    }

    /// Whether canvass writes this format.
    pub fn is_written(self) -> bool {
        self.row().create.is_some()
    }

    /// Opens a reader for a source of this format.
    pub fn open(self, source: Source, options: &ReadOptions) -> Box<dyn Reader> {
        (self.row().open)(source, options)
    }

    /// A writer of this format.
    ///
    /// # Errors
    /// [`WriteError::NotWritten`] if the format can only be read, or the error of the sink.
    pub fn create(self, sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
        let create = self.row().create.ok_or(WriteError::NotWritten(self))?;
        create(sink, options)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_format_has_its_row() {
        let variants = [
            Format::Candump,
            Format::CandumpConsole,
            Format::Pcap,
            Format::Pcapng,
            Format::Mcap,
            Format::Asc,
            Format::Trc,
            Format::MiniMon,
            Format::Blf,
            Format::PythonCanCsv,
            Format::Pasted,
        ];
        assert_eq!(variants.len(), FORMATS.len());
        for format in variants {
            assert_eq!(format.row().format, format);
            assert_eq!(Format::by_id(format.id()), Some(format));
        }
    }
}
