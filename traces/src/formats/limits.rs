//! What each written format can't hold.

use super::Format;
use crate::Loss;

impl Format {
    /// What is lost of records that have it, when they are written in this format; empty for one that is only read.
    ///
    /// [`Loss::TimeZone`] is of captures in local time only, or in UTC, whichever is not the format's own.
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
            Self::CandumpConsole | Self::MiniMon | Self::Blf => &[],
        }
    }
}
