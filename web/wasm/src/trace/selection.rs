//! The rows that pass a filter or contain a text.

use super::store::{BLOCK, Step, Store, Walk};
use canvass_analyzer::Meaning;
use canvass_analyzer::filter::{Filter, Subject};
use canvass_traces::Channels;
use std::ops::ControlFlow;

/// The criteria of a selection or search.
pub struct Wanted {
    filter: Option<Filter>,
    /// The text in lower case.
    text: String,
}

impl Wanted {
    /// Criteria for rows that pass the filter, if there is one, and have the text in their meaning, CAN-ID or data.
    pub fn new(filter: Option<Filter>, text: &str) -> Self {
        Self { filter, text: text.to_lowercase() }
    }

    /// Whether the frame in the notation `63F#4018100100000000` has the text, whose blanks are left out.
    fn is_in_frame(&self, step: &Step<'_>) -> bool {
        let mut shown = step.record.frame.to_string().to_lowercase();
        let compact: String = self.text.chars().filter(|c| !c.is_whitespace()).collect();
        shown.retain(|c| !c.is_whitespace());
        !compact.is_empty() && shown.contains(&compact)
    }

    fn has(&self, step: &Step<'_>, channels: &Channels) -> bool {
        let Step { record, decoded, network, .. } = step;
        let subject = Subject { record, decoded, channel: channels.name(record.channel) };
        self.filter.as_ref().is_none_or(|filter| filter.matches(&subject))
            && (self.text.is_empty()
                || self.is_in_frame(step)
                || network.bus(record.channel).is_some_and(|bus| {
                    Meaning::new(record, decoded, bus).to_string().to_lowercase().contains(&self.text)
                }))
    }
}

/// A set of rows, with one bit each.
pub struct Selection {
    wanted: Wanted,
    walk: Option<Walk>,
    bits: Vec<u64>,
    /// Number of selected rows before each block.
    before: Vec<usize>,
    len: usize,
}

const WORDS: usize = BLOCK / 64;

impl Selection {
    /// A selection before any record was examined.
    pub fn new(wanted: Wanted, store: &Store) -> Self {
        Self { wanted, walk: store.walk(0), bits: Vec::new(), before: Vec::new(), len: 0 }
    }

    /// Examines the next records; `false` at the end.
    pub fn step(&mut self, store: &Store, records: usize, channels: &Channels) -> bool {
        let Some(walk) = &mut self.walk else { return false };
        let (wanted, bits, before, len) = (&self.wanted, &mut self.bits, &mut self.before, &mut self.len);
        walk.until(store, walk.row().saturating_add(records), |step| {
            if step.row % BLOCK == 0 {
                before.push(*len);
                bits.resize(bits.len() + WORDS, 0);
            }
            if wanted.has(step, channels)
                && let Some(word) = bits.get_mut(step.row / 64)
            {
                *word |= 1 << (step.row % 64);
                *len += 1;
            }
            ControlFlow::Continue(())
        });
        walk.row() < store.len()
    }

    /// Number of examined records.
    pub fn looked_at(&self) -> usize {
        self.walk.as_ref().map_or(0, Walk::row)
    }

    /// Number of selected rows so far.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether no row is selected so far.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The indexes of `count` selected rows from number `from` on.
    pub fn places(&self, from: usize, count: usize) -> Vec<usize> {
        let block = self.before.partition_point(|before| *before <= from).saturating_sub(1);
        let skipped = from - self.before.get(block).copied().unwrap_or(0).min(from);
        let words = self.bits.iter().enumerate().skip(block * WORDS);
        let set =
            words.flat_map(|(at, word)| (0..64).filter(move |bit| word >> bit & 1 != 0).map(move |bit| at * 64 + bit));
        set.skip(skipped).take(count).collect()
    }

    /// Number of selected rows before an index.
    pub fn rank(&self, place: usize) -> usize {
        let block = place / BLOCK;
        let Some(before) = self.before.get(block) else { return self.len };
        let words = self.bits.get(block * WORDS..=place / 64).unwrap_or_default();
        let ones: usize = words.iter().map(|word| word.count_ones() as usize).sum();
        let beyond = self.bits.get(place / 64).map_or(0, |word| (word >> (place % 64)).count_ones() as usize);
        before + ones - beyond
    }
}

/// A search for the next wanted row after `from`, or the last wanted row before it, in steps.
pub struct Search {
    wanted: Wanted,
    walk: Option<Walk>,
    end: usize,
    found: Option<usize>,
    /// Whether the last match is wanted instead of the first.
    last: bool,
}

impl Search {
    /// Begins a search after `from`, or before it; without it among all rows.
    pub fn new(wanted: Wanted, store: &Store, from: Option<usize>, backwards: bool) -> Self {
        let (begin, end) = match (from, backwards) {
            (None, _) => (0, store.len()),
            (Some(from), true) => (0, from),
            (Some(from), false) => (from + 1, store.len()),
        };
        let mut walk = store.walk(begin);
        if let Some(walk) = &mut walk {
            walk.until(store, begin, |_| ControlFlow::Continue(()));
        }
        Self { wanted, walk, end, found: None, last: backwards }
    }

    /// Examines the next records; `false` at the end.
    pub fn step(&mut self, store: &Store, records: usize, channels: &Channels) -> bool {
        let Some(walk) = &mut self.walk else { return false };
        let (wanted, found, last) = (&self.wanted, &mut self.found, self.last);
        walk.until(store, walk.row().saturating_add(records).min(self.end), |step| {
            if wanted.has(step, channels) {
                *found = Some(step.row);
                if !last {
                    return ControlFlow::Break(());
                }
            }
            ControlFlow::Continue(())
        });
        walk.row() < self.end && (last || found.is_none())
    }

    /// The found row.
    pub const fn found(&self) -> Option<usize> {
        self.found
    }
}

/// The first row at this time or later.
pub fn row_at(store: &Store, time: canvass_traces::Timestamp) -> usize {
    let block = store.block_of(time);
    let Some(mut walk) = store.walk(block * BLOCK) else { return 0 };
    walk.until(store, block * BLOCK, |_| ControlFlow::Continue(()));
    walk.until(store, store.len(), |step| {
        if step.record.timestamp >= time { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    walk.row().saturating_sub(1)
}
