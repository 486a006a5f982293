//! Shares in percent.

use canvass_traces::Duration;
use std::fmt;

/// A share in percent.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Default)]
pub struct Percent(pub u64);

impl Percent {
    /// This share of a time.
    pub const fn of(self, whole: Duration) -> Duration {
        Duration(whole.nanos().saturating_mul(self.0) / 100)
    }
}

impl fmt::Display for Percent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} %", self.0)
    }
}
