//! `--max-size` and `--max-time`: limits of one upload.

use crate::live::{parse_size, parse_span};
use canvass_bus::client::{Bound, Excess, UploadLimit};
use canvass_traces::Duration;

/// The limits of each upload, as typed.
#[derive(Clone, Copy, clap::Args)]
pub struct UploadLimitArgs {
    /// Maximum number of bytes read of an object, such as 64k or 32M (default: 16 MiB of a single object, 64 KiB of
    /// each if many are read)
    #[arg(long, value_name = "SIZE", value_parser = parse_size)]
    max_size: Option<u64>,
    /// Maximum time for reading an object, such as 30s or 1h (default: 10 minutes for a single object, 30 s for each
    /// if many are read)
    #[arg(long, value_name = "SPAN", value_parser = parse_span)]
    max_time: Option<Duration>,
}

impl UploadLimitArgs {
    /// The typed limits. A limit that was not typed is taken from `usual`.
    pub fn or(self, usual: UploadLimit) -> UploadLimit {
        let bytes = self.max_size.map(|size| usize::try_from(size).unwrap_or(usize::MAX));
        UploadLimit { bytes: bytes.unwrap_or(usual.bytes), time: self.max_time.unwrap_or(usual.time) }
    }
}

/// The exceeded limit, with the option that raises it.
pub fn told(excess: &Excess) -> String {
    let option = match excess.bound {
        Bound::Bytes(_) => "--max-size",
        Bound::Time(_) => "--max-time",
    };
    format!("{excess} ({option} raises the limit)")
}
