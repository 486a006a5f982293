//! The capture formats, one file each.

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
pub(crate) mod pcap;
pub(crate) mod pcapng;
pub(crate) mod python_can_csv;
pub(crate) mod socketcan;
pub(crate) mod trc;
mod trc_numbers;
mod trc_row;
mod trc_writer;

use crate::{ReadOptions, Reader, Source, WriteError, WriteOptions, Writer};
use std::io::Write;

/// A capture file format.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Format {
    /// candump's log.
    Candump,
    /// candump's output on a console.
    CandumpConsole,
    /// pcap.
    Pcap,
    /// pcapng.
    Pcapng,
    /// MCAP.
    Mcap,
    /// Vector ASC.
    Asc,
    /// PEAK TRC.
    Trc,
    /// IXXAT MiniMon CSV.
    MiniMon,
    /// Vector BLF.
    Blf,
    /// python-can CSV.
    PythonCanCsv,
}

/// One format: what it is called, how it is recognised, read and written.
pub(crate) struct Row {
    format: Format,
    id: &'static str,
    summary: &'static str,
    /// The usual file name endings, the first one for writing.
    extensions: &'static [&'static str],
    /// Whether a source that begins like this is of this format; sees up to [`Format::SNIFF`] bytes.
    sniff: fn(&[u8]) -> bool,
    open: fn(Source, &ReadOptions) -> Box<dyn Reader>,
    create: Option<Create>,
}

type Create = fn(Box<dyn Write>, &WriteOptions) -> Result<Box<dyn Writer>, WriteError>;

/// In the order in which they are tried: what has a magic number first, free text last.
const FORMATS: &[Row] = &[
    Row {
        format: Format::Pcapng,
        id: "pcapng",
        summary: "pcapng (Wireshark), link types SocketCAN, Linux SLL and SLL2",
        extensions: &["pcapng", "ntar"],
        sniff: pcapng::sniff,
        open: pcapng::open,
        create: Some(pcapng::create),
    },
    Row {
        format: Format::Pcap,
        id: "pcap",
        summary: "pcap (tcpdump), link types SocketCAN, Linux SLL and SLL2",
        extensions: &["pcap", "cap"],
        sniff: pcap::sniff,
        open: pcap::open,
        create: Some(pcap::create),
    },
    Row {
        format: Format::Mcap,
        id: "mcap",
        summary: "MCAP (ROS 1, ROS 2, Foxglove) with CAN messages",
        extensions: &["mcap"],
        sniff: mcap::sniff,
        open: mcap::open,
        create: Some(mcap::create),
    },
    Row {
        format: Format::Blf,
        id: "blf",
        summary: "Vector BLF",
        extensions: &["blf"],
        sniff: blf::sniff,
        open: blf::open,
        create: None,
    },
    Row {
        format: Format::Trc,
        id: "trc",
        summary: "PEAK TRC 1.0 to 2.1",
        extensions: &["trc"],
        sniff: trc::sniff,
        open: trc::open,
        create: Some(trc::create),
    },
    Row {
        format: Format::PythonCanCsv,
        id: "csv",
        summary: "python-can CSV",
        extensions: &["csv"],
        sniff: python_can_csv::sniff,
        open: python_can_csv::open,
        create: Some(python_can_csv::create),
    },
    Row {
        format: Format::MiniMon,
        id: "minimon",
        summary: "IXXAT MiniMon CSV",
        extensions: &["csv"],
        sniff: minimon::sniff,
        open: minimon::open,
        create: None,
    },
    Row {
        format: Format::Asc,
        id: "asc",
        summary: "Vector ASC",
        extensions: &["asc"],
        sniff: asc::sniff,
        open: asc::open,
        create: Some(asc::create),
    },
    Row {
        format: Format::Candump,
        id: "candump",
        summary: "candump log (candump -l, -L, -f)",
        extensions: &["log"],
        sniff: candump_log::sniff,
        open: candump_log::open,
        create: Some(candump_log::create),
    },
    Row {
        format: Format::CandumpConsole,
        id: "candump-console",
        summary: "candump console output",
        extensions: &["txt"],
        sniff: candump_console::sniff,
        open: candump_console::open,
        create: None,
    },
];

impl Format {
    /// How many bytes of a source are looked at to recognise its format.
    pub const SNIFF: usize = 64 * 1024;

    /// All formats.
    pub fn all() -> impl Iterator<Item = Self> {
        FORMATS.iter().map(|row| row.format)
    }

    /// The format with that id, such as `candump`.
    pub fn by_id(id: &str) -> Option<Self> {
        FORMATS.iter().find(|row| row.id == id).map(|row| row.format)
    }

    /// The format that is usually written to files with that ending (without the dot).
    pub fn by_extension(extension: &str) -> Option<Self> {
        let writes =
            |row: &&Row| row.create.is_some() && row.extensions.iter().any(|e| e.eq_ignore_ascii_case(extension));
        FORMATS.iter().find(writes).map(|row| row.format)
    }

    /// The format of a source that begins like this.
    pub fn sniff(head: &[u8]) -> Option<Self> {
        FORMATS.iter().find(|row| (row.sniff)(head)).map(|row| row.format)
    }

    fn row(self) -> &'static Row {
        // Every variant has its row: a test checks it.
        FORMATS.iter().find(|row| row.format == self).unwrap_or(&FORMATS[0])
    }

    /// The name on the command line.
    pub fn id(self) -> &'static str {
        self.row().id
    }

    /// The format in a few words.
    pub fn summary(self) -> &'static str {
        self.row().summary
    }

    /// The usual file name endings.
    pub fn extensions(self) -> &'static [&'static str] {
        self.row().extensions
    }

    /// Whether canvass writes it.
    pub fn is_written(self) -> bool {
        self.row().create.is_some()
    }

    /// A reader of a source that is known, or said, to be of this format.
    pub fn open(self, source: Source, options: &ReadOptions) -> Box<dyn Reader> {
        (self.row().open)(source, options)
    }

    /// A writer of this format.
    ///
    /// # Errors
    /// [`WriteError::NotWritten`] if the format is only read, or what the sink reports.
    pub fn create(self, sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
        let create = self.row().create.ok_or(WriteError::NotWritten(self))?;
        create(sink, options)
    }
}

impl std::fmt::Display for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.id())
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
        ];
        assert_eq!(variants.len(), FORMATS.len());
        for format in variants {
            assert_eq!(format.row().format, format);
            assert_eq!(Format::by_id(format.id()), Some(format));
        }
    }
}
