//! The limits of each written format.

use super::Format;
use crate::Loss;

impl Format {
    /// The properties of records that this format can't hold; empty for a read-only format.
    ///
    /// [`Loss::TimeZone`] concerns only captures whose time base is not that of the format: captures in local time for
    /// a format in UTC, and vice versa.
    pub fn losses(self) -> &'static [Loss] {
        match self {
            Self::Candump => &[Loss::ChannelName, Loss::TimeZone],
            Self::Pcap => {
                &[Loss::ChannelName, Loss::Direction, Loss::Date, Loss::UnknownDate, Loss::TimeZone, Loss::Comment]
            }
            Self::Mcap => {
                &[Loss::Frame, Loss::Direction, Loss::UnknownDate, Loss::TimeZone, Loss::FdFlags, Loss::RawDlc]
            }
            Self::Asc | Self::Trc => &[
                Loss::Frame,
                Loss::ChannelName,
                Loss::Direction,
                Loss::TimeResolution,
                Loss::TimeZone,
                Loss::ErrorDetail,
            ],
            Self::PythonCanCsv => &[
                Loss::Frame,
                Loss::ChannelName,
                Loss::Direction,
                Loss::TimeZone,
                Loss::FdFlags,
                Loss::RawDlc,
                Loss::Comment,
            ],
            Self::Pcapng => &[Loss::UnknownDate, Loss::TimeZone],
            Self::CandumpConsole | Self::MiniMon | Self::Blf | Self::Pasted => &[],
        }
    }
}
