//! Bits on the bus over time, in a bounded number of bins: when they don't suffice, each two become one.

use canvass_traces::{Duration, Timestamp};

/// Bits over time.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Load {
    start: Option<Timestamp>,
    width: Duration,
    bins: Vec<u64>,
}

impl Default for Load {
    fn default() -> Self {
        Self { start: None, width: Self::FINEST, bins: Vec::new() }
    }
}

impl Load {
    /// How many bins there are at most.
    pub const BINS: usize = 1024;
    /// The width that bins begin with.
    pub const FINEST: Duration = Duration::from_millis(100);

    /// Adds the bits of a frame.
    pub fn add(&mut self, now: Timestamp, bits: u32) {
        let start = *self.start.get_or_insert(now);
        // A clock that stepped back before the start counts for the first bin.
        let elapsed = now.since(start).nanos();
        let mut at = elapsed / self.width.nanos();
        while at >= Self::BINS as u64 {
            self.double();
            at = elapsed / self.width.nanos();
        }
        let at = at as usize;
        if self.bins.len() <= at {
            self.bins.resize(at + 1, 0);
        }
        self.bins[at] += u64::from(bits);
    }

    #[cold]
    fn double(&mut self) {
        self.bins = self.bins.chunks(2).map(|pair| pair.iter().sum()).collect();
        self.width = self.width.times(2);
    }

    /// When the first bin begins.
    pub const fn start(&self) -> Option<Timestamp> {
        self.start
    }

    /// How long each bin is.
    pub const fn width(&self) -> Duration {
        self.width
    }

    /// The bits in each bin.
    pub fn bins(&self) -> &[u64] {
        &self.bins
    }

    /// All bits.
    pub fn bits(&self) -> u64 {
        self.bins.iter().sum()
    }

    /// A number of bits within a time, in percent of what fits.
    pub fn percent(bits: u64, within: Duration, bit_rate: u32) -> f64 {
        let most = within.nanos() as f64 / 1e9 * f64::from(bit_rate);
        if most > 0.0 { bits as f64 * 100.0 / most } else { 0.0 }
    }

    /// The fullest bin: its begin and its bits.
    pub fn peak(&self) -> Option<(Timestamp, u64)> {
        let (at, &bits) = self.bins.iter().enumerate().max_by_key(|bin| bin.1)?;
        Some((self.start? + self.width.times(at as u64), bits))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_double_and_keep_the_sum() {
        let mut load = Load::default();
        for second in 0..10_000 {
            load.add(Timestamp(second * 1_000_000_000), 100);
        }
        assert!(load.bins().len() <= Load::BINS);
        assert_eq!(load.bits(), 1_000_000);
        assert_eq!(load.width(), Duration::from_millis(12_800));
        assert!((Load::percent(1_250, Duration::from_millis(10), 250_000) - 50.0).abs() < 1e-9);
    }
}
