//! The capture formats, one file each, and their table.

pub(crate) mod asc;
mod asc_row;
mod asc_writer;
pub(crate) mod blf;
pub(crate) mod candump_console;
pub(crate) mod candump_log;
mod candump_usual;
pub(crate) mod crtd;
pub(crate) mod mcap;
pub(crate) mod mf4;
pub(crate) mod minimon;
pub(crate) mod pasted;
pub(crate) mod pcap;
pub(crate) mod pcapng;
mod python_can;
pub(crate) mod python_can_csv;
pub(crate) mod socketcan;
pub(crate) mod sqlite;
pub(crate) mod trc;
mod trc_numbers;
mod trc_row;
mod trc_writer;
pub(crate) mod wireshark_text;

use crate::{Format, Loss, ReadOptions, Reader, Source, WriteError, WriteOptions, Writer};
use std::io::Write;

/// A format: its properties, detection, reader and writer.
pub(crate) struct FormatEntry {
    format: Format,
    /// Its name on the command line.
    id: &'static str,
    summary: &'static str,
    /// The usual file name endings, the first one for writing.
    extensions: &'static [&'static str],
    /// Whether a source that begins with these bytes has the format. Gets at most [`Format::SNIFF`] bytes.
    sniff: fn(&[u8]) -> bool,
    open: fn(Source, &ReadOptions) -> Box<dyn Reader>,
    /// The writer; none for a format that is only read.
    writing: Option<Writing>,
}

/// How a format is written.
struct Writing {
    create: Create,
    /// The properties of records that the format can't hold.
    losses: &'static [Loss],
    /// Whether the beginning of the file states what is known only at its end: [`Writer::beginning`].
    rewrites_beginning: bool,
}

type Create = fn(Box<dyn Write>, &WriteOptions) -> Result<Box<dyn Writer>, WriteError>;

/// The formats in the order of detection: those with a magic number first, free text last.
const FORMATS: &[FormatEntry] = &[
    FormatEntry {
        format: Format::Pcapng,
        id: "pcapng",
        summary: "pcapng (Wireshark), link types SocketCAN, Linux SLL and SLL2",
        extensions: &["pcapng", "ntar"],
        sniff: pcapng::sniff,
        open: pcapng::open,
        writing: Some(Writing {
            create: pcapng::create,
            losses: &[Loss::UnknownDate, Loss::TimeZone],
            rewrites_beginning: false,
        }),
    },
    FormatEntry {
        format: Format::Pcap,
        id: "pcap",
        summary: "pcap (tcpdump), link types SocketCAN, Linux SLL and SLL2",
        extensions: &["pcap", "cap"],
        sniff: pcap::sniff,
        open: pcap::open,
        writing: Some(Writing {
            create: pcap::create,
            losses: &[Loss::ChannelName, Loss::Direction, Loss::Date, Loss::UnknownDate, Loss::TimeZone, Loss::Comment],
            rewrites_beginning: false,
        }),
    },
    FormatEntry {
        format: Format::Mcap,
        id: "mcap",
        summary: "MCAP (ROS 1, ROS 2, Foxglove) with CAN messages",
        extensions: &["mcap"],
        sniff: mcap::sniff,
        open: mcap::open,
        writing: Some(Writing {
            create: mcap::create,
            losses: &[Loss::Frame, Loss::Direction, Loss::UnknownDate, Loss::TimeZone, Loss::FdFlags, Loss::RawDlc],
            rewrites_beginning: false,
        }),
    },
    FormatEntry {
        format: Format::Blf,
        id: "blf",
        summary: "Vector BLF",
        extensions: &["blf"],
        sniff: blf::sniff,
        open: blf::open,
        writing: WRITING_BLF,
    },
    FormatEntry {
        format: Format::Mf4,
        id: "mf4",
        summary: "ASAM MDF 4 with bus logging of CAN",
        extensions: &["mf4"],
        sniff: mf4::sniff,
        open: mf4::open,
        writing: WRITING_MF4,
    },
    FormatEntry {
        format: Format::Sqlite,
        id: "sqlite",
        summary: "python-can SQLite database",
        extensions: &["db", "sqlite"],
        sniff: sqlite::sniff,
        open: sqlite::open,
        writing: None,
    },
    FormatEntry {
        format: Format::Trc,
        id: "trc",
        summary: "PEAK TRC 1.0 to 2.1",
        extensions: &["trc"],
        sniff: trc::sniff,
        open: trc::open,
        writing: Some(Writing { create: trc::create, losses: OF_TEXT_OF_WINDOWS, rewrites_beginning: false }),
    },
    FormatEntry {
        format: Format::PythonCanCsv,
        id: "csv",
        summary: "python-can CSV",
        extensions: &["csv"],
        sniff: python_can_csv::sniff,
        open: python_can_csv::open,
        writing: Some(Writing {
            create: python_can_csv::create,
            losses: &[
                Loss::Frame,
                Loss::ChannelName,
                Loss::Direction,
                Loss::TimeZone,
                Loss::FdFlags,
                Loss::RawDlc,
                Loss::Comment,
            ],
            rewrites_beginning: false,
        }),
    },
    FormatEntry {
        format: Format::MiniMon,
        id: "minimon",
        summary: "IXXAT MiniMon CSV",
        extensions: &["csv"],
        sniff: minimon::sniff,
        open: minimon::open,
        writing: None,
    },
    FormatEntry {
        format: Format::Crtd,
        id: "crtd",
        summary: "CRTD (Open Vehicle Monitoring System, SavvyCAN)",
        extensions: &["crtd", "txt"],
        sniff: crtd::sniff,
        open: crtd::open,
        writing: None,
    },
    FormatEntry {
        format: Format::Asc,
        id: "asc",
        summary: "Vector ASC",
        extensions: &["asc"],
        sniff: asc::sniff,
        open: asc::open,
        writing: Some(Writing { create: asc::create, losses: OF_TEXT_OF_WINDOWS, rewrites_beginning: false }),
    },
    FormatEntry {
        format: Format::WiresharkText,
        id: "wireshark-text",
        summary: "text of Wireshark and tshark with the bytes of packets",
        extensions: &["txt"],
        sniff: wireshark_text::sniff,
        open: wireshark_text::open,
        writing: None,
    },
    FormatEntry {
        format: Format::Candump,
        id: "candump",
        summary: "candump log (candump -l, -L, -f)",
        extensions: &["log"],
        sniff: candump_log::sniff,
        open: candump_log::open,
        writing: Some(Writing {
            create: candump_log::create,
            losses: &[Loss::ChannelName, Loss::TimeZone],
            rewrites_beginning: false,
        }),
    },
    FormatEntry {
        format: Format::CandumpConsole,
        id: "candump-console",
        summary: "candump console output",
        extensions: &["txt"],
        sniff: candump_console::sniff,
        open: candump_console::open,
        writing: None,
    },
    FormatEntry {
        format: Format::Pasted,
        id: "pasted",
        summary: "pasted lines of frames, and tables of other tools",
        extensions: &["txt", "csv"],
        sniff: pasted::sniff,
        open: pasted::open,
        writing: None,
    },
];

#[cfg(not(target_family = "wasm"))]
const WRITING_BLF: Option<Writing> = Some(Writing {
    create: blf::create,
    losses: &[
        Loss::Frame,
        Loss::ChannelName,
        Loss::Direction,
        Loss::TimeResolution,
        Loss::TimeZone,
        Loss::ErrorDetail,
        Loss::Comment,
    ],
    rewrites_beginning: true,
});

#[cfg(not(target_family = "wasm"))]
const WRITING_MF4: Option<Writing> = Some(Writing {
    create: mf4::create,
    losses: &[
        Loss::Frame,
        Loss::ChannelName,
        Loss::Direction,
        Loss::TimeResolution,
        Loss::UnknownDate,
        Loss::ErrorDetail,
        Loss::Comment,
    ],
    rewrites_beginning: true,
});

/// A browser gives no file whose beginning could be written again.
#[cfg(target_family = "wasm")]
const WRITING_BLF: Option<Writing> = None;
#[cfg(target_family = "wasm")]
const WRITING_MF4: Option<Writing> = None;

/// The losses of the text formats of tools on Windows: Vector ASC and PEAK TRC.
const OF_TEXT_OF_WINDOWS: &[Loss] =
    &[Loss::Frame, Loss::ChannelName, Loss::Direction, Loss::TimeResolution, Loss::TimeZone, Loss::ErrorDetail];

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
            row.writing.is_some() && row.extensions.iter().any(|e| e.eq_ignore_ascii_case(extension))
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

    /// The properties of records that this format can't hold; empty for a read-only format.
    ///
    /// [`Loss::TimeZone`] concerns only captures whose time base is not that of the format: captures in local time for
    /// a format in UTC, and vice versa.
    pub fn losses(self) -> &'static [Loss] {
        self.row().writing.as_ref().map_or(&[], |writing| writing.losses)
    }

    fn row(self) -> &'static FormatEntry {
        let row = FORMATS.iter().find(|row| row.format == self);
        debug_assert!(row.is_some(), "{self:?} has no row in FORMATS");
        row.unwrap_or(&FORMATS[0])
    }

    /// Whether the beginning of a written file is written again at its end, so that the file can be neither a pipe nor
    /// compressed.
    pub fn rewrites_beginning(self) -> bool {
        self.row().writing.as_ref().is_some_and(|writing| writing.rewrites_beginning)
    }

    /// Whether canvass writes this format.
    pub fn is_written(self) -> bool {
        self.row().writing.is_some()
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
        let writing = self.row().writing.as_ref().ok_or(WriteError::NotWritten(self))?;
        (writing.create)(sink, options)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The variants are numbered up to the last one: one without a row leaves a gap.
    #[test]
    fn every_format_has_one_row() {
        let mut numbers: Vec<usize> = FORMATS.iter().map(|row| row.format as usize).collect();
        numbers.sort_unstable();
        assert!(numbers.into_iter().eq(0..=Format::Pasted as usize));
        for format in Format::all() {
            assert_eq!(Format::by_id(format.id()), Some(format));
        }
    }
}
