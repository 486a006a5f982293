//! `--max-size` and `--max-time`: how much of one upload is read.

use crate::live::{parse_size, parse_span};
use canvass_bus::client::{Bound, Excess, UploadLimit};
use canvass_traces::Duration;

/// The limit of each upload, as typed.
#[derive(Clone, Copy, clap::Args)]
pub struct UploadLimitArgs {
    /// How many bytes of an object are read at most, such as 64k or 32M; without it 16 MiB of a single object, and 64 KiB of
    /// each where many are read
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    max_size: Option<u64>,
    /// How long reading an object may take, such as 30s or 1h; without it 10 minutes for a single object, and 30 s for
    /// each where many are read
    #[arg(long, value_name = "SPAN", value_parser = parse_span)]
    max_time: Option<Duration>,
}

impl UploadLimitArgs {
    /// With what was not typed from `usual`.
    pub fn or(self, usual: UploadLimit) -> UploadLimit {
        let bytes = self.max_size.map(|size| usize::try_from(size).unwrap_or(usize::MAX));
        UploadLimit { bytes: bytes.unwrap_or(usual.bytes), time: self.max_time.unwrap_or(usual.time) }
    }
}

/// What exceeds the limit, with the option that raises it.
pub fn told(excess: &Excess) -> String {
    let option = match excess.bound {
        Bound::Bytes(_) => "--max-size",
        Bound::Time(_) => "--max-time",
    };
    format!("{excess} ({option} raises the limit)")
}
