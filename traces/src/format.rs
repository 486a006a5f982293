//! The capture formats by name. `formats` has the row of each: its properties, detection, reader and writer.

use std::fmt;

/// A capture file format.
///
/// ```
/// use canvass_traces::Format;
///
/// let by_extension = |ending| Format::all().find(|format| format.extensions().contains(&ending));
/// assert_eq!(by_extension("pcapng"), Some(Format::Pcapng));
/// assert_eq!(Format::Pcapng.to_string(), "pcapng");
/// let only_read: Vec<_> = Format::all().filter(|format| !format.is_written()).collect();
/// assert_eq!(only_read, [Format::Sqlite, Format::MiniMon, Format::Crtd, Format::WiresharkText, Format::CandumpConsole, Format::Pasted]);
/// ```
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Format {
    /// The log of candump.
    Candump,
    /// The output of candump on a console.
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
    /// ASAM MDF 4.
    Mf4,
    /// python-can CSV.
    PythonCanCsv,
    /// python-can's SQLite database.
    Sqlite,
    /// The text of Wireshark and tshark.
    WiresharkText,
    /// The log of the Open Vehicle Monitoring System.
    Crtd,
    /// Lines of frames in no known format. It stays the last one.
    Pasted,
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}
