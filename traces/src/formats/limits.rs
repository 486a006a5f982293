//! What each written format can't hold.

use super::Format;
use crate::Loss;

impl Format {
    /// What is lost of records that have it, when they are written in this format; empty for one that is only read.
    ///
    /// A format that holds either local times or UTC loses which of both it was, of captures of the other kind only.
    pub fn losses(self) -> &'static [Loss] {
        match self {
            Self::Candump => &[Loss::ChannelName, Loss::TimeZone],
            Self::Pcap => &[Loss::ChannelName, Loss::Direction, Loss::Date],
            Self::Mcap => &[Loss::Frame, Loss::Direction, Loss::FdFlags, Loss::RawDlc],
            Self::Asc => &[
                Loss::Frame,
                Loss::ChannelName,
                Loss::Direction,
                Loss::TimeResolution,
                Loss::TimeZone,
                Loss::ErrorDetail,
            ],
            Self::Trc => &[
                Loss::Frame,
                Loss::ChannelName,
                Loss::Direction,
                Loss::TimeResolution,
                Loss::TimeZone,
                Loss::ErrorDetail,
            ],
            Self::PythonCanCsv => {
                &[Loss::Frame, Loss::ChannelName, Loss::Direction, Loss::TimeZone, Loss::FdFlags, Loss::RawDlc]
            }
            Self::Pcapng | Self::CandumpConsole | Self::MiniMon | Self::Blf => &[],
        }
    }
}
