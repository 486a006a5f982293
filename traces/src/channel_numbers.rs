//! Numbers of channels, for formats without channel names.

use crate::{ChannelId, Loss, Losses};
use std::collections::{BTreeMap, BTreeSet};

/// The number of each channel seen so far.
#[derive(Default)]
pub(crate) struct ChannelNumbers {
    numbers: BTreeMap<ChannelId, u16>,
    taken: BTreeSet<u16>,
    /// The lowest number that may be free: all numbers below it are taken.
    free_from: u16,
}

impl ChannelNumbers {
    /// The number of a channel, from 1: its name if that is a number, else the next free number; then the loss of the
    /// name is counted.
    pub(crate) fn number(&mut self, channel: ChannelId, name: &str, losses: &mut Losses) -> u16 {
        let number = match self.numbers.get(&channel) {
            Some(number) => *number,
            None => self.assign(channel, name),
        };
        if !is_number(name, number) {
            losses.count(Loss::ChannelName);
        }
        number
    }

    fn assign(&mut self, channel: ChannelId, name: &str) -> u16 {
        let own = name.parse().ok().filter(|&n| n > 0 && is_number(name, n) && !self.taken.contains(&n));
        let number = own.unwrap_or_else(|| {
            self.free_from = (self.free_from.max(1)..=u16::MAX).find(|n| !self.taken.contains(n)).unwrap_or(u16::MAX);
            self.free_from
        });
        let is_free = self.taken.insert(number);
        debug_assert!(is_free, "at most {} channels leave a number free", crate::Channels::MAX);
        self.numbers.insert(channel, number);
        number
    }
}

fn is_number(name: &str, number: u16) -> bool {
    name.bytes().all(|b| b.is_ascii_digit()) && !name.starts_with('0') && name.parse() == Ok(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_numbers_keep_them() {
        let (mut numbers, mut losses) = (ChannelNumbers::default(), Losses::default());
        assert_eq!(numbers.number(ChannelId(0), "2", &mut losses), 2);
        assert!(losses.is_empty());
        assert_eq!(numbers.number(ChannelId(1), "can0", &mut losses), 1);
        assert_eq!(numbers.number(ChannelId(2), "can1", &mut losses), 3);
        assert_eq!(numbers.number(ChannelId(3), "3", &mut losses), 4);
        assert_eq!(numbers.number(ChannelId(1), "can0", &mut losses), 1);
        assert_eq!(losses.iter().collect::<Vec<_>>(), [(Loss::ChannelName, 4)]);
    }
}
