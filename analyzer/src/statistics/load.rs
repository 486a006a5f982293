//! Bits on the bus over time, in a limited number of bins: when they are used up, pairs of bins are merged.

use canvass_traces::{Duration, Timestamp};

/// Bits over time.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Load {
    start: Option<Timestamp>,
    width: Duration,
    bins: Vec<u64>,
    extremes: Vec<Extremes>,
    /// The current interval of [`Load::FINEST`]: its number since the start, and its bits.
    current: (u64, u64),
    /// The begin of the current interval.
    begin: Timestamp,
    /// The bin of the current interval.
    bin: usize,
}

/// The emptiest and the fullest interval of [`Load::FINEST`] within a bin.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Extremes {
    /// The bits of the emptiest interval.
    pub least: u64,
    /// The bits of the fullest interval.
    pub most: u64,
    /// Number of intervals with frames.
    counted: u32,
}

impl Default for Load {
    fn default() -> Self {
        Self {
            start: None,
            width: Self::FINEST,
            bins: Vec::new(),
            extremes: Vec::new(),
            current: (0, 0),
            begin: Timestamp(0),
            bin: 0,
        }
    }
}

impl Load {
    /// Maximum number of bins.
    pub(crate) const BINS: usize = 1024;
    /// The initial width of bins.
    pub const FINEST: Duration = Duration::from_millis(100);

    /// Adds the bits of a frame.
    #[inline]
    pub fn add(&mut self, now: Timestamp, bits: u32) {
        // Most frames are in the same interval as the frame before.
        if now.since(self.begin) < Self::FINEST
            && now >= self.begin
            && let Some(bin) = self.bins.get_mut(self.bin)
        {
            self.current.1 += u64::from(bits);
            *bin += u64::from(bits);
        } else {
            self.turn(now, bits);
        }
    }

    /// Adds the bits of a frame in another interval than the frame before.
    #[cold]
    fn turn(&mut self, now: Timestamp, bits: u32) {
        let start = *self.start.get_or_insert(now);
        // If the clock stepped back before the start, frames count for the first bin.
        let elapsed = now.since(start).nanos();
        let finest = elapsed / Self::FINEST.nanos();
        if finest != self.current.0 {
            self.settle();
            self.current = (finest, 0);
        }
        self.begin = start + Self::FINEST.times(finest);
        self.current.1 += u64::from(bits);
        let mut at = elapsed / self.width.nanos();
        while at >= Self::BINS as u64 {
            self.double();
            at = elapsed / self.width.nanos();
        }
        let at = at as usize;
        self.bin = at;
        if self.bins.len() <= at {
            self.bins.resize(at + 1, 0);
            self.extremes.resize(at + 1, Extremes::default());
        }
        self.bins[at] += u64::from(bits);
    }

    #[cold]
    fn double(&mut self) {
        self.bins = self.bins.chunks(2).map(|pair| pair.iter().sum()).collect();
        self.extremes = self.extremes.chunks(2).map(Extremes::of).collect();
        self.width = self.width.times(2);
    }

    /// Ends the current interval.
    fn settle(&mut self) {
        let (finest, bits) = self.current;
        let at = finest / (self.width.nanos() / Self::FINEST.nanos());
        if let Some(bin) = usize::try_from(at).ok().and_then(|at| self.extremes.get_mut(at)) {
            *bin = Extremes::of(&[*bin, Extremes { least: bits, most: bits, counted: 1 }]);
        }
    }

    /// The emptiest and the fullest interval of [`Load::FINEST`] in each bin, among complete intervals; the last bin
    /// may not be over.
    pub fn extremes(&self) -> Vec<Extremes> {
        let mut load = self.clone();
        load.settle();
        let times = (self.width.nanos() / Self::FINEST.nanos()) as u32;
        let last = load.extremes.len().saturating_sub(1);
        for (at, bin) in load.extremes.iter_mut().enumerate() {
            // Intervals without frames were never counted.
            if bin.counted < times && at < last {
                bin.least = 0;
            }
        }
        load.extremes
    }

    /// The begin of the first bin.
    pub const fn start(&self) -> Option<Timestamp> {
        self.start
    }

    /// The width of each bin.
    pub const fn width(&self) -> Duration {
        self.width
    }

    /// The bits in each bin.
    pub fn bins(&self) -> &[u64] {
        &self.bins
    }

    /// Number of all bits.
    pub fn bits(&self) -> u64 {
        self.bins.iter().sum()
    }

    /// This number of bits within a time, as a percentage of the capacity.
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

impl Extremes {
    /// The extremes of several bins together.
    fn of(parts: &[Self]) -> Self {
        let seen = || parts.iter().filter(|part| part.counted > 0);
        Self {
            least: seen().map(|part| part.least).min().unwrap_or(0),
            most: seen().map(|part| part.most).max().unwrap_or(0),
            counted: parts.iter().map(|part| part.counted).sum(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_burst_stays_visible_however_wide_bins_become() {
        let mut load = Load::default();
        for tenth in 0..4096 {
            load.add(Timestamp(tenth * 100_000_000), if tenth == 1000 { 5_000 } else { 100 });
        }
        assert_eq!(load.width(), Duration::from_millis(400));
        let extremes = load.extremes();
        assert_eq!((extremes[250].least, extremes[250].most), (100, 5_000));
        assert_eq!((extremes[251].least, extremes[251].most), (100, 100));
        assert_eq!((extremes[1023].least, extremes[1023].most), (100, 100), "the last one too");
        load.add(Timestamp(5000 * 100_000_000), 100);
        assert_eq!(load.extremes()[550].least, 0, "nothing was sent");
    }

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
