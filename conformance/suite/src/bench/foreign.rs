//! How much of the bus others take: what they leave is what the device under test has to live with.

use canvass_traces::{CanId, Duration, Record, bit_length};
use std::collections::HashMap;

/// The traffic of others while a case ran.
#[derive(Clone, Debug, Default)]
pub(crate) struct Foreign {
    bits: u64,
    frames: HashMap<CanId, u64>,
}

/// Where nobody knows the bit rate, the highest is taken: the load is then more than what is reckoned.
const HIGHEST_BIT_RATE: u32 = 1_000_000;

/// More identifiers than this are not distinguished.
const IDENTIFIERS: usize = 4_096;

impl Foreign {
    /// Counts a frame of others.
    pub fn count(&mut self, record: &Record) {
        self.bits += u64::from(bit_length(&record.frame).unwrap_or(0));
        if self.frames.len() < IDENTIFIERS {
            *self.frames.entry(record.frame.id()).or_default() += 1;
        }
    }

    /// The share of the bus in percent, over that span.
    pub fn load(&self, span: Duration, bit_rate: Option<u32>) -> u64 {
        let possible = u128::from(bit_rate.unwrap_or(HIGHEST_BIT_RATE)) * u128::from(span.0) / 1_000_000_000;
        u64::try_from(u128::from(self.bits) * 100 / possible.max(1)).unwrap_or(u64::MAX)
    }

    /// The identifier that was seen most often, and how often.
    pub fn loudest(&self) -> Option<(CanId, u64)> {
        self.frames.iter().map(|(&id, &count)| (id, count)).max_by_key(|&(id, count)| (count, std::cmp::Reverse(id)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{ChannelId, Frame, Timestamp};

    #[test]
    fn the_load_is_that_of_the_bits() {
        let mut foreign = Foreign::default();
        let frame = Frame::full(CanId::standard_masked(0x123), [0x55; 8]);
        let bits = u64::from(bit_length(&frame).unwrap());
        for _ in 0..1_000 {
            foreign.count(&Record::new(Timestamp::ZERO, ChannelId(0), frame));
        }
        assert_eq!(foreign.load(Duration::from_secs(1), Some(125_000)), bits * 1_000 * 100 / 125_000);
        assert_eq!(foreign.loudest(), Some((frame.id(), 1_000)));
    }

    /// Where the bit rate is not known, it is taken for 1 Mbit/s; no time at all is no reason to divide by zero.
    #[test]
    fn the_load_is_never_too_high_where_the_bit_rate_is_not_known() {
        let mut foreign = Foreign::default();
        let frame = Frame::full(CanId::standard_masked(0x123), [0x55; 8]);
        let bits = u64::from(bit_length(&frame).unwrap());
        (0..4_000).for_each(|_| foreign.count(&Record::new(Timestamp::ZERO, ChannelId(0), frame)));
        assert_eq!(foreign.load(Duration::from_secs(1), None), bits * 4_000 * 100 / 1_000_000);
        assert_eq!(foreign.load(Duration::from_secs(2), None), bits * 4_000 * 100 / 2_000_000);
        assert_eq!(foreign.load(Duration::ZERO, None), bits * 4_000 * 100);
        assert_eq!(foreign.load(Duration::from_secs(1), Some(2)), bits * 4_000 * 100 / 2);
        assert_eq!(Foreign::default().load(Duration::from_secs(1), None), 0);
    }

    /// Of identifiers that are equally loud it is the one with the highest priority; those beyond 4096 are not distinguished.
    #[test]
    fn the_loudest_is_named() {
        let record = |id| Record::new(Timestamp::ZERO, ChannelId(0), Frame::full(CanId::extended(id).unwrap(), [0; 8]));
        let mut foreign = Foreign::default();
        assert_eq!(foreign.loudest(), None);
        for id in [3, 2, 1, 2, 1] {
            foreign.count(&record(id));
        }
        assert_eq!(foreign.loudest(), Some((CanId::extended(1).unwrap(), 2)));
        (100..10_000).for_each(|id| foreign.count(&record(id)));
        assert_eq!(foreign.frames.len(), 4_096);
    }
}
