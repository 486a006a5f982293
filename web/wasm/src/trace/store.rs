//! All records, in compressed blocks; and the network as it was at the begin of some of them, so that what any record
//! means is worked out from the nearest one on.

use super::pack::{self, Before};
use canvass_analyzer::network::{Decoded, Network};
use canvass_traces::{Record, Timestamp};
use std::ops::ControlFlow;

/// Records of a block.
pub const BLOCK: usize = 4096;

/// The records.
#[derive(Default)]
pub struct Store {
    blocks: Vec<Block>,
    /// The block that is being filled.
    open: Vec<u8>,
    open_first: Option<Timestamp>,
    before: Before,
    len: usize,
    bytes: usize,
    /// Records that there was no more room for.
    left_out: u64,
    snapshots: Vec<Network>,
    /// Blocks from one snapshot to the next.
    spacing: usize,
}

struct Block {
    packed: Box<[u8]>,
    first: Timestamp,
    /// The latest time of this block and those before it.
    latest: Timestamp,
}

impl Store {
    /// The memory that records may take: those of a capture of about a gigabyte.
    const MOST_BYTES: usize = 256 << 20;
    /// So many snapshots of one bus; of several buses fewer.
    const SNAPSHOTS: usize = 256;

    /// How many records there are.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// How many records there was no room for.
    pub const fn left_out(&self) -> u64 {
        self.left_out
    }

    /// When the first record was seen.
    pub fn start(&self) -> Option<Timestamp> {
        self.blocks.first().map(|block| block.first).or(self.open_first)
    }

    /// Takes the next record; `network` has seen all before it.
    #[inline]
    pub fn push(&mut self, record: &Record, network: &Network, buses: usize) {
        if self.len.is_multiple_of(BLOCK) && !self.begin_block(network, buses) {
            self.left_out += 1;
            return;
        }
        self.open_first.get_or_insert(record.timestamp);
        pack::push(record, &mut self.before, &mut self.open);
        self.len += 1;
    }

    /// Closes the block that is full, and begins another; unless there is no more room.
    fn begin_block(&mut self, network: &Network, buses: usize) -> bool {
        if self.bytes >= Self::MOST_BYTES {
            return false;
        }
        self.close_block();
        self.spacing = self.spacing.max(1);
        let most = (Self::SNAPSHOTS / buses.max(1)).max(2);
        if self.blocks.len() == self.snapshots.len() * self.spacing {
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
        true
    }

    fn close_block(&mut self) {
        if let Some(first) = self.open_first.take() {
            let packed = lz4_flex::block::compress_prepend_size(&self.open).into_boxed_slice();
            self.bytes += packed.len();
            let latest = self.blocks.last().map_or(first, |block| block.latest.max(first));
            self.blocks.push(Block { packed, first, latest });
        }
        self.open.clear();
        self.before = Before::default();
    }

    /// The records of a block.
    fn block(&self, at: usize) -> Option<Vec<u8>> {
        match self.blocks.get(at) {
            Some(block) => lz4_flex::block::decompress_size_prepended(&block.packed).ok(),
            None if at == self.blocks.len() => Some(self.open.clone()),
            None => None,
        }
    }

    /// The last block in which a record of that time can be, if records came in the order of their times.
    pub fn block_of(&self, time: Timestamp) -> usize {
        self.blocks.partition_point(|block| block.latest <= time).saturating_sub(1)
    }

    /// A walk that begins before `row`.
    pub fn walk(&self, row: usize) -> Option<Walk> {
        let snapshot = (row / BLOCK / self.spacing.max(1)).min(self.snapshots.len().checked_sub(1)?);
        let network = self.snapshots.get(snapshot)?.snapshot();
        Some(Walk { network, row: snapshot * self.spacing * BLOCK })
    }
}

/// Goes through the records from one on, with what the network knows there.
pub struct Walk {
    network: Network,
    row: usize,
}

/// A record and what it means.
pub struct Step<'a> {
    /// Its place among all records.
    pub row: usize,
    /// The record.
    pub record: &'a Record,
    /// What it means.
    pub decoded: Decoded,
    /// What is known once it was seen.
    pub network: &'a Network,
}

impl Walk {
    /// The row that comes next.
    pub const fn row(&self) -> usize {
        self.row
    }

    /// Shows `see` the records before `end`, until it breaks off.
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
