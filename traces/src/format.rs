//! The names of the capture formats. `formats` has their detection, readers and writers.

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
/// assert_eq!(only_read, [Format::Blf, Format::MiniMon, Format::CandumpConsole, Format::Pasted]);
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
    /// python-can CSV.
    PythonCanCsv,
    /// Lines of frames in no known format.
    Pasted,
}

/// The names and properties of a format.
struct Facts {
    id: &'static str,
    summary: &'static str,
    /// The usual file name endings, the first one for writing.
    extensions: &'static [&'static str],
}

const fn facts(id: &'static str, summary: &'static str, extensions: &'static [&'static str]) -> Facts {
    Facts { id, summary, extensions }
}

impl Format {
    const fn facts(self) -> Facts {
        match self {
            Self::Candump => facts("candump", "candump log (candump -l, -L, -f)", &["log"]),
            Self::CandumpConsole => facts("candump-console", "candump console output", &["txt"]),
            Self::Pcap => facts("pcap", "pcap (tcpdump), link types SocketCAN, Linux SLL and SLL2", &["pcap", "cap"]),
            Self::Pcapng => {
                facts("pcapng", "pcapng (Wireshark), link types SocketCAN, Linux SLL and SLL2", &["pcapng", "ntar"])
            }
            Self::Mcap => facts("mcap", "MCAP (ROS 1, ROS 2, Foxglove) with CAN messages", &["mcap"]),
            Self::Asc => facts("asc", "Vector ASC", &["asc"]),
            Self::Trc => facts("trc", "PEAK TRC 1.0 to 2.1", &["trc"]),
            Self::MiniMon => facts("minimon", "IXXAT MiniMon CSV", &["csv"]),
            Self::Blf => facts("blf", "Vector BLF", &["blf"]),
            Self::PythonCanCsv => facts("csv", "python-can CSV", &["csv"]),
            Self::Pasted => facts("pasted", "pasted lines of frames, and tables of other tools", &["txt", "csv"]),
        }
    }

    /// The name on the command line.
    pub const fn id(self) -> &'static str {
        self.facts().id
    }

    /// The format in a few words.
    pub const fn summary(self) -> &'static str {
        self.facts().summary
    }

    /// The usual file name endings.
    pub const fn extensions(self) -> &'static [&'static str] {
        self.facts().extensions
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.id())
    }
}
