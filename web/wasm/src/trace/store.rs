//! All records, in blocks, which are compressed when there are many, and snapshots of the network at the beginning of
//! some blocks. Decoding of any record begins at the nearest snapshot before it. While records are added, they are only
//! stored. When all records are there, [`Indexing`] decodes them and makes the snapshots.

use super::overview::Overview;
use super::pack::{self, Before};
use canvass_analyzer::network::{Decoded, Network};
use canvass_traces::{Record, Timestamp};
use std::borrow::Cow;
use std::ops::ControlFlow;

/// Number of records in a block.
pub const BLOCK: usize = 4096;

/// The store of all records.
#[derive(Default)]
pub struct Store {
    blocks: Vec<Block>,
    /// The block that is being filled.
    open: Vec<u8>,
    open_first: Option<Timestamp>,
    before: Before,
    len: usize,
    bytes: usize,
    /// Number of compressed blocks; they are the first blocks.
    compressed: usize,
    /// Number of bytes in the uncompressed blocks.
    plain_bytes: usize,
    /// Number of records for which there was no room.
    left_out: u64,
    snapshots: Vec<Network>,
    /// Number of blocks from one snapshot to the next.
    spacing: usize,
}

struct Block {
    packed: Packed,
    first: Timestamp,
    /// The latest time in this block and all earlier blocks.
    latest: Timestamp,
}

enum Packed {
    Plain(Box<[u8]>),
    Compressed(Box<[u8]>),
}

impl Store {
    /// Number of bytes that are kept uncompressed, so that the user of a usual capture does not wait for its
    /// compression.
    const PLAIN_BYTES: usize = 32 << 20;
    /// Limit of the memory for records: enough for a capture of about a gigabyte.
    pub const MOST_BYTES: usize = 256 << 20;
    /// Maximum number of snapshots for one bus; several buses have fewer.
    const SNAPSHOTS: usize = 256;

    /// Approximate memory for the records of a usual log of `log` bytes.
    pub fn room(log: u64) -> u64 {
        let (plain, compressed) = (log / 100 * 40, log / 100 * 28);
        plain.min(Self::PLAIN_BYTES as u64).max(compressed).min(Self::MOST_BYTES as u64)
    }

    /// Number of records.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no records.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Number of records for which there was no room.
    pub const fn left_out(&self) -> u64 {
        self.left_out
    }

    /// The time of the first record.
    pub fn start(&self) -> Option<Timestamp> {
        self.blocks.first().map(|block| block.first).or(self.open_first)
    }

    /// A store without records. `network` holds the knowledge about the buses before the first record.
    pub fn new(network: Network) -> Self {
        Self { snapshots: vec![network], spacing: 1, ..Self::default() }
    }

    /// Adds the next record.
    #[inline]
    pub fn push(&mut self, record: &Record) {
        if self.len.is_multiple_of(BLOCK) && !self.begin_block() {
            self.left_out += 1;
            return;
        }
        self.open_first.get_or_insert(record.timestamp);
        pack::push(record, &mut self.before, &mut self.open);
        self.len += 1;
    }

    /// Closes the full block and begins another; `false` if there is no more room.
    fn begin_block(&mut self) -> bool {
        if self.bytes >= Self::MOST_BYTES {
            return false;
        }
        self.close_block();
        true
    }

    /// Keeps a snapshot of the network before a block, if it is the turn of this block.
    fn remember(&mut self, block: usize, network: &Network, buses: usize) {
        let most = (Self::SNAPSHOTS / buses.max(1)).max(2);
        if block == self.snapshots.len() * self.spacing {
            self.snapshots.push(network.snapshot());
        }
        while self.snapshots.len() > most {
            let mut at = 0;
            self.snapshots.retain(|_| {
                at += 1;
                at % 2 == 1
            });
            self.spacing *= 2;
        }
    }

    fn close_block(&mut self) {
        if let Some(first) = self.open_first.take() {
            let packed: Box<[u8]> = self.open.as_slice().into();
            self.bytes += packed.len();
            self.plain_bytes += packed.len();
            let latest = self.blocks.last().map_or(first, |block| block.latest.max(first));
            self.blocks.push(Block { packed: Packed::Plain(packed), first, latest });
        }
        self.open.clear();
        self.before = Before::default();
        while self.plain_bytes > Self::PLAIN_BYTES && self.compress_next() {}
    }

    /// Compresses the first uncompressed block; `false` if there is none.
    fn compress_next(&mut self) -> bool {
        let Some(block) = self.blocks.get_mut(self.compressed) else { return false };
        if let Packed::Plain(plain) = &block.packed {
            let packed = lz4_flex::block::compress_prepend_size(plain).into_boxed_slice();
            self.plain_bytes -= plain.len();
            self.bytes = self.bytes - plain.len() + packed.len();
            block.packed = Packed::Compressed(packed);
        }
        self.compressed += 1;
        true
    }

    /// The records of a block.
    fn block(&self, at: usize) -> Option<Cow<'_, [u8]>> {
        match self.blocks.get(at).map(|block| &block.packed) {
            Some(Packed::Plain(plain)) => Some(Cow::Borrowed(plain)),
            Some(Packed::Compressed(packed)) => lz4_flex::block::decompress_size_prepended(packed).ok().map(Cow::Owned),
            None if at == self.blocks.len() => Some(Cow::Borrowed(&self.open)),
            None => None,
        }
    }

    /// The last block that can contain a record of this time, if records are in the order of their times.
    pub fn block_of(&self, time: Timestamp) -> usize {
        self.blocks.partition_point(|block| block.latest <= time).saturating_sub(1)
    }

    /// A walk that begins at the last snapshot at or before `row`.
    pub fn walk(&self, row: usize) -> Option<Walk> {
        let snapshot = (row / BLOCK / self.spacing.max(1)).min(self.snapshots.len().checked_sub(1)?);
        let network = self.snapshots.get(snapshot)?.snapshot();
        Some(Walk { network, row: snapshot * self.spacing * BLOCK })
    }
}

/// Decodes all records once: for the overview above the list, and for the snapshots, with which any part of the list
/// appears quickly.
pub struct Indexing {
    walk: Option<Walk>,
    buses: usize,
    /// The number of frames over time, so far.
    pub overview: Overview,
}

impl Indexing {
    /// Begins to index a complete store with the records of `buses` buses.
    pub fn new(store: &Store, buses: usize) -> Self {
        Self { walk: store.walk(0), buses, overview: Overview::default() }
    }

    /// Decodes the next records; `false` at the end.
    pub fn step(&mut self, store: &mut Store, records: usize) -> bool {
        let Some(walk) = &mut self.walk else { return false };
        let end = walk.row.saturating_add(records).min(store.len());
        while walk.row < end {
            let (began, block) = (walk.row, walk.row / BLOCK);
            if began.is_multiple_of(BLOCK) {
                store.remember(block, &walk.network, self.buses);
            }
            walk.until(store, end.min((block + 1) * BLOCK), |step| {
                self.overview.take(step.record.timestamp, &step.decoded);
                ControlFlow::Continue(())
            });
            if walk.row == began {
                break;
            }
        }
        if walk.row < end || end == store.len() {
            self.walk = None;
        }
        self.walk.is_some()
    }

    /// Number of examined records; `all` once the index is complete.
    pub fn looked_at(&self, all: usize) -> usize {
        self.walk.as_ref().map_or(all, Walk::row)
    }
}

/// Decodes the records from a given record on. It begins with the state of the network at the last snapshot before this
/// record.
pub struct Walk {
    network: Network,
    row: usize,
}

/// A record with its meaning.
pub struct Step<'a> {
    /// The index of the record among all records.
    pub row: usize,
    /// The record.
    pub record: &'a Record,
    /// The meaning of the record.
    pub decoded: Decoded,
    /// The network after this record.
    pub network: &'a Network,
}

impl Walk {
    /// The index of the next record.
    pub const fn row(&self) -> usize {
        self.row
    }

    /// Passes the records before `end` to `see`, until `see` returns `Break`.
    pub fn until(&mut self, store: &Store, end: usize, mut see: impl FnMut(&Step<'_>) -> ControlFlow<()>) {
        while self.row < end.min(store.len()) {
            let Some(block) = store.block(self.row / BLOCK) else { return };
            let (mut bytes, mut before) = (&block[..], Before::default());
            for _ in 0..self.row % BLOCK {
                if pack::take(&mut bytes, &mut before).is_none() {
                    return;
                }
            }
            let began = self.row;
            while self.row < end {
                let Some(record) = pack::take(&mut bytes, &mut before) else { break };
                let decoded = self.network.handle(&record);
                let step = Step { row: self.row, record: &record, decoded, network: &self.network };
                let flow = see(&step);
                self.row += 1;
                if flow.is_break() {
                    return;
                }
            }
            if self.row == began {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::parse_frame;

    /// A store of `blocks` blocks with a node whose state changes all the time.
    fn filled(blocks: usize) -> Store {
        let mut store = Store::new(Network::new());
        let frames = ["000#0105", "705#05", "000#8005", "705#7F", "605#4000100000000000", "585#4300100096010200"];
        for n in 0..blocks * BLOCK + 7 {
            let mut record = parse_frame(frames[n / 3 % frames.len()]).unwrap();
            record.timestamp = Timestamp(n as u64 * 1_000_000);
            store.push(&record);
        }
        store
    }

    fn indexed(mut store: Store, buses: usize, records: usize) -> (Store, Indexing) {
        let mut indexing = Indexing::new(&store, buses);
        while indexing.step(&mut store, records) {}
        (store, indexing)
    }

    /// The meanings of the records from a row on.
    fn from(store: &Store, row: usize) -> Vec<String> {
        let mut told = Vec::new();
        store.walk(row).unwrap().until(store, row + 9, |step| {
            if step.row >= row {
                told.push(format!("{} {:?}", step.row, step.decoded));
            }
            ControlFlow::Continue(())
        });
        told
    }

    #[test]
    fn rows_mean_the_same_whether_the_list_was_worked_out_or_not() {
        let (plain, (store, indexing)) = (filled(9), indexed(filled(9), 1, 1_000));
        assert_eq!((store.snapshots.len(), store.spacing), (10, 1));
        assert_eq!(indexing.looked_at(store.len()), store.len());
        for row in [0, 1, BLOCK - 1, BLOCK, 3 * BLOCK + 5, 9 * BLOCK, store.len() - 1] {
            assert_eq!(from(&store, row), from(&plain, row), "{row}");
        }
    }

    #[test]
    fn rows_mean_the_same_whether_their_blocks_are_compressed_or_not() {
        let (plain, mut store) = (filled(3), filled(3));
        while store.compress_next() {}
        assert_eq!((store.compressed, store.plain_bytes), (3, 0));
        assert!(store.bytes < plain.bytes, "{} {}", store.bytes, plain.bytes);
        for row in [0, 2 * BLOCK - 3, 3 * BLOCK - 1, store.len() - 1] {
            assert_eq!(from(&store, row), from(&plain, row), "{row}");
        }
    }

    #[test]
    fn how_far_a_step_goes_makes_no_difference() {
        let told = |records| indexed(filled(2), 1, records).1.overview.told();
        assert_eq!(told(777), told(usize::MAX));
        assert_eq!(told(777), told(BLOCK));
    }

    #[test]
    fn of_many_buses_there_are_fewer_snapshots_of_the_network() {
        let (store, _) = indexed(filled(9), Store::SNAPSHOTS / 4, BLOCK);
        assert_eq!((store.snapshots.len(), store.spacing), (3, 4));
        assert_eq!(from(&store, 8 * BLOCK), from(&filled(9), 8 * BLOCK));
    }

    #[test]
    fn a_capture_without_frames_needs_no_work() {
        let (store, indexing) = indexed(Store::new(Network::new()), 0, 10);
        assert!(store.is_empty() && indexing.looked_at(0) == 0);
    }
}
