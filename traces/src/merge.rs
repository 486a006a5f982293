//! Several captures as one, by time.
//!
//! - The merge reads one record ahead in each source, and only while more than one source is left. It does not sort: if
//!   the clock of a source steps back, its records keep their order.
//! - If records have the same time, those of the source named first come first.
//! - A damage is returned as soon as it is found: after the record before it in its own source. A damage with a
//!   salvaged record takes that record's place in time.
//! - Channels of different sources are different channels, even if their names are equal: with more than one source
//!   every channel is named `FILE:CHANNEL` ([`Naming::BySource`]). A rule that looked at the names would have to
//!   rename a channel once another of the same name turns up. [`Naming::SameBus`] is for parts of one recording,
//!   or several recorders on the same bus: equal names are then one channel.

use crate::{Capture, ChannelId, Channels, Damage, Reader, Record, SkipSet, TimeBase, Timestamp};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::path::Path;

/// The names of the channels of several captures.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Naming {
    /// `FILE:CHANNEL`, if there is more than one source.
    #[default]
    BySource,
    /// The names of the sources; equal names are one channel.
    SameBus,
}

/// Several captures as one; iterates over items, each with the index of the source that it comes from.
///
/// ```
/// use canvass_traces::{Capture, Merge, Naming, ReadOptions, Reader, Source};
///
/// let open = |name: &str, log: &str| Capture::from_source(name, Source::from_bytes(log), &ReadOptions::default());
/// let line = open("line.log", "(1.000000) can0 000#0100\n(3.000000) can0 080#\n")?;
/// let cell = open("cell.log", "(2.000000) can0 705#05\n")?;
/// let mut merge = Merge::new(vec![line, cell], Naming::BySource);
/// let mut seen = Vec::new();
/// while let Some((source, item)) = merge.next() {
///     let record = item.expect("nothing is damaged");
///     seen.push(format!("{} {}", merge.name(source), record.frame));
/// }
/// assert_eq!(seen, ["line.log 000#0100", "cell.log 705#05", "line.log 080#"]);
/// # Ok::<(), canvass_traces::OpenError>(())
/// ```
pub struct Merge {
    sources: Vec<MergedSource>,
    channels: Channels,
    /// The name of each merged channel in its own source.
    own_names: Vec<Box<str>>,
    /// The times of the heads, the earliest first.
    heap: BinaryHeap<Reverse<(Timestamp, usize)>>,
    /// Sources whose next item is unknown yet, in reverse order.
    wanted: Vec<usize>,
    /// Whether a merged channel has another number than in its source.
    renumbered: bool,
}

/// One of the merged captures.
struct MergedSource {
    capture: Capture,
    /// The prefix of the channels' names.
    prefix: Option<String>,
    /// The merged channels, by the source's own ids.
    channels: Vec<ChannelId>,
    /// The next item, if it has a time.
    head: Option<Item>,
}

type Item = Result<Record, Damage>;

impl Merge {
    /// Merges the captures; of equal times the first capture's record comes first.
    pub fn new(captures: Vec<Capture>, naming: Naming) -> Self {
        let prefixes = match naming {
            Naming::BySource if captures.len() > 1 => labels(&captures).into_iter().map(Some).collect(),
            _ => vec![None; captures.len()],
        };
        let source = |(capture, prefix)| MergedSource { capture, prefix, channels: Vec::new(), head: None };
        Self {
            wanted: (0..captures.len()).rev().collect(),
            sources: captures.into_iter().zip(prefixes).map(source).collect(),
            channels: Channels::new(),
            own_names: Vec::new(),
            heap: BinaryHeap::new(),
            renumbered: false,
        }
    }

    /// The captures, in the order in which they were given.
    pub fn sources(&self) -> impl ExactSizeIterator<Item = &Capture> {
        self.sources.iter().map(|source| &source.capture)
    }

    /// The name of a source; empty for an unknown source.
    pub fn name(&self, source: usize) -> &str {
        self.sources.get(source).map_or("", |source| source.capture.name())
    }

    /// The channels seen so far, of all sources; every record's channel is among them.
    pub fn channels(&self) -> &Channels {
        &self.channels
    }

    /// A channel's name in its own source, without the source's name in front.
    pub fn own_name(&self, channel: ChannelId) -> &str {
        self.own_names.get(usize::from(channel.0)).map_or("?", |name| name)
    }

    /// The bit rate of a channel's bus in bit/s, if its source gives it. Known after the first record of the channel.
    pub fn bit_rate(&self, channel: ChannelId) -> Option<u32> {
        let of_channel = |source: &&MergedSource| source.channels.contains(&channel);
        self.sources.iter().filter(of_channel).find_map(|source| source.capture.bit_rate())
    }

    /// The time base of the first source, as far as it is known.
    pub fn time_base(&self) -> TimeBase {
        self.sources.first().map_or(TimeBase::None, |source| source.capture.time_base())
    }

    /// The first source with another time base than the first one: their times have no common origin and are merged
    /// as numbers. Known after one record of each source.
    pub fn odd_source(&self) -> Option<usize> {
        self.sources.iter().position(|source| source.capture.time_base() != self.time_base())
    }

    /// Writes the next item that is not skipped into `record`. After many skipped records the next record is returned
    /// even if the set has it, so that the caller gets control from time to time.
    #[inline]
    pub fn next_kept(&mut self, skip: &mut SkipSet, record: &mut Record) -> Option<(usize, Result<(), Damage>)> {
        // A single source numbers its channels itself.
        let [source] = &mut self.sources[..] else { return self.next_kept_of_many(skip, record) };
        if self.renumbered {
            return self.next_kept_of_many(skip, record);
        }
        Some(match source.capture.next_kept(skip, record)? {
            Ok(()) => {
                record.channel = self.channel(0, record.channel);
                (0, Ok(()))
            }
            Err(damage) => (0, Err(self.renumber(0, damage))),
        })
    }

    fn next_kept_of_many(&mut self, skip: &mut SkipSet, record: &mut Record) -> Option<(usize, Result<(), Damage>)> {
        for _ in 0..SkipSet::IN_A_ROW {
            match self.next()? {
                (_, Ok(next)) if skip.skips(&next) => {}
                (source, item) => return Some((source, item.map(|next| *record = next))),
            }
        }
        self.next().map(|(source, item)| (source, item.map(|next| *record = next)))
    }

    /// Reads ahead in a source; an item without a time is returned at once.
    fn look_ahead(&mut self, at: usize) -> Option<Item> {
        let item = self.take(at)?;
        let time = match &item {
            Ok(record) => record.timestamp,
            Err(Damage { salvaged: Some(record), .. }) => record.timestamp,
            Err(_) => {
                self.wanted.push(at);
                return Some(item);
            }
        };
        let source = self.sources.get_mut(at)?;
        debug_assert!(source.head.is_none(), "a source is read ahead by one record");
        source.head = Some(item);
        self.heap.push(Reverse((time, at)));
        None
    }

    /// The next item of a source, with its merged channel.
    #[inline]
    fn take(&mut self, at: usize) -> Option<Item> {
        Some(match self.sources.get_mut(at)?.capture.next()? {
            Ok(record) => {
                let channel = self.channel(at, record.channel);
                Ok(record.on(channel))
            }
            Err(damage) => Err(self.renumber(at, damage)),
        })
    }

    /// Replaces the channel of a damage's salvaged record by the merged channel.
    #[cold]
    fn renumber(&mut self, at: usize, mut damage: Damage) -> Damage {
        if let Some(record) = damage.salvaged.as_deref_mut() {
            record.channel = self.channel(at, record.channel);
        }
        damage
    }

    /// The merged channel of a source's channel.
    #[inline]
    fn channel(&mut self, at: usize, channel: ChannelId) -> ChannelId {
        let known = self.sources.get(at).and_then(|source| source.channels.get(usize::from(channel.0)));
        known.copied().unwrap_or_else(|| self.intern(at, channel))
    }

    /// Registers the channels of a source up to `channel`.
    #[cold]
    fn intern(&mut self, at: usize, channel: ChannelId) -> ChannelId {
        let Some(source) = self.sources.get_mut(at) else { return channel };
        for own in source.channels.len()..=usize::from(channel.0) {
            let own = source.capture.channels().name(ChannelId(own as u16));
            let merged = match &source.prefix {
                Some(prefix) => self.channels.intern(&format!("{prefix}:{own}")),
                None => self.channels.intern(own),
            };
            if self.own_names.len() <= usize::from(merged.0) {
                self.own_names.push(own.into());
            }
            self.renumbered |= usize::from(merged.0) != source.channels.len();
            source.channels.push(merged);
        }
        debug_assert!(
            source.channels.len() > usize::from(channel.0),
            "the source's channels are registered up to this"
        );
        source.channels.last().copied().unwrap_or(channel)
    }
}

impl Iterator for Merge {
    type Item = (usize, Item);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        if self.sources.len() == 1 {
            // A single source needs no reading ahead: a live frame is returned at once.
            return Some((0, self.take(0)?));
        }
        while let Some(at) = self.wanted.pop() {
            if let Some(damage) = self.look_ahead(at) {
                return Some((at, damage));
            }
        }
        let Reverse((_, at)) = self.heap.pop()?;
        self.wanted.push(at);
        let head = self.sources.get_mut(at)?.head.take();
        debug_assert!(head.is_some(), "each time in the heap belongs to the head of a source");
        Some((at, head?))
    }
}

/// A unique name for each capture: the file's name, or the path if another capture has the same file name; with a
/// number if the same path occurred before.
fn labels(captures: &[Capture]) -> Vec<String> {
    let file_name = |capture: &Capture| match Path::new(capture.name()).file_name() {
        Some(name) => name.to_string_lossy().into_owned(),
        None => capture.name().to_owned(),
    };
    let mut labels: Vec<String> = Vec::new();
    for capture in captures {
        let mut label = file_name(capture);
        if captures.iter().filter(|other| file_name(other) == label).count() > 1 {
            label = capture.name().to_owned();
        }
        let numbered = (2_usize..).map(|n| format!("{label}#{n}"));
        let label = std::iter::once(label.clone()).chain(numbered).find(|label| !labels.contains(label));
        labels.extend(label);
    }
    labels
}

impl std::fmt::Debug for Merge {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.sources()).finish()
    }
}
