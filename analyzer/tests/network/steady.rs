//! Frames that are skipped as steady have no effect: all other frames have the same meaning without them.

use canvass_analyzer::dictionary::{DeviceDescription, KnownDevice, eds};
use canvass_analyzer::network::{Decoded, Network, Skipping};
use canvass_analyzer::{Meaning, NodeId};
use canvass_traces::{CanId, Capture, ChannelId, Frame, Merge, Naming, ReadOptions, Record, Timestamp};
use std::path::Path;
use std::sync::LazyLock;

/// Pseudo-random numbers that are the same on every machine (xorshift64*).
struct Random(u64);

impl Random {
    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 33) % end
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }
}

/// Traffic in which much is repeated, and sometimes everything changes.
struct Traffic {
    random: Random,
    now: u64,
    records: Vec<Record>,
}

/// CAN-IDs to which PDOs and other services may move.
const PLACES: [u32; 8] = [0x181, 0x182, 0x1A0, 0x281, 0x105, 0x106, 0x6A0, 0x080];

impl Traffic {
    fn generated(seed: u64, frames: usize) -> Vec<Record> {
        let random = Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        let mut traffic = Self { random, now: 1, records: Vec::new() };
        while traffic.records.len() < frames {
            if traffic.random.below(6) == 0 { traffic.something() } else { traffic.more_of_the_same() }
        }
        traffic.records
    }

    fn push(&mut self, frame: Frame) {
        self.now += 1_000_000 * (1 + self.random.below(40));
        let channel = ChannelId(u16::from(self.random.below(5) == 0));
        self.records.push(Record::new(Timestamp(self.now), channel, frame));
        // Some interfaces record frames twice.
        if self.random.below(20) == 0 {
            self.records.push(Record::new(Timestamp(self.now), channel, frame));
        }
    }

    fn send(&mut self, id: u32, data: &[u8]) {
        self.push(Frame::new(CanId::standard_masked(id), data).unwrap());
    }

    fn more_of_the_same(&mut self) {
        let node = 1 + self.random.below(3) as u32;
        let byte = self.random.below(4) as u8;
        match self.random.below(9) {
            0..3 => self.send(0x180 + node, &[byte, 1, 2, 3, 4, 5, 6, 7]),
            3 => {
                let id = self.random.of(&PLACES);
                self.send(id, &[byte, 0x04, 0x60, 0, 1, 2, 3, 4]);
            }
            4..6 => self.send(0x700 + node, &[5]),
            6 => self.send(0x80, &[]),
            7 => self.send(0x300 + u32::from(byte), &[byte]),
            _ => self.push(Frame::new(CanId::extended_masked(0x18FF_0000 + node), &[byte]).unwrap()),
        }
    }

    fn something(&mut self) {
        let node = 1 + self.random.below(3) as u32;
        let byte = self.random.below(4) as u8;
        match self.random.below(16) {
            0..4 => self.moved(node),
            4 => self.mapped(node),
            5 => {
                let command = self.random.of(&[1, 2, 0x80, 0x81, 0x82]);
                self.send(0, &[command, byte]);
            }
            6 => self.send(0x700 + node, &[0]),
            7 => {
                let state = self.random.of(&[4, 0x7F, 0x85, 5]);
                self.send(0x700 + node, &[state]);
            }
            8 => {
                self.push(Frame::remote(CanId::standard_masked(0x700 + node), 1).unwrap());
                self.send(0x700 + node, &[5 | byte << 7]);
            }
            9 => self.send(0x80 + node, &[]),
            10 => self.send(0x80 + node, &[byte, 0x81, byte, 0, 0, 0, 0, 0]),
            11 => {
                self.send(0x105, &[byte, 1]);
                self.send(0x106, &[!byte, !1]);
            }
            12 => self.renamed(node),
            13 => self.write(node, 0x6001, 0, 1000 + u32::from(byte)),
            14 => self.write(node, 0x1010, 1, u32::from_le_bytes(*b"save")),
            _ => self.read(node, 0x1000, 0, self.now as u32 % 2 * 0x10000 + 0x196),
        }
    }

    /// Moves or removes a COB-ID: of a PDO, EMCY, SYNC, TIME, a further SDO server or an SRDO.
    fn moved(&mut self, node: u32) {
        let (index, sub) = self.random.of(&[
            (0x1800, 1),
            (0x1801, 1),
            (0x1400, 1),
            (0x1014, 0),
            (0x1005, 0),
            (0x1012, 0),
            (0x1201, 1),
            (0x1201, 2),
            (0x1301, 1),
            (0x1301, 5),
            (0x1301, 6),
        ]);
        let invalid = if self.random.below(5) == 0 { 0x8000_0000 } else { 0 };
        let value = if sub == 1 && index == 0x1301 { 1 } else { self.random.of(&PLACES) | invalid };
        if self.random.below(2) == 0 { self.write(node, index, sub, value) } else { self.read(node, index, sub, value) }
    }

    fn mapped(&mut self, node: u32) {
        let count = self.random.of(&[1, 2, 0, 0xFE, 0xFF]);
        self.write(node, 0x1A00, 1, 0x6004_0020);
        self.write(node, 0x1A00, 2, 0x6030_0110);
        self.write(node, 0x1A00, 0, count);
    }

    /// Layer setting assigns another node-ID to a device.
    fn renamed(&mut self, node: u32) {
        self.send(0x7E5, &[4, 1, 0, 0, 0, 0, 0, 0]);
        self.send(0x7E5, &[0x11, node as u8, 0, 0, 0, 0, 0, 0]);
        self.send(0x7E4, &[0x11, 0, 0, 0, 0, 0, 0, 0]);
        self.send(0x700 + node, &[0]);
    }

    fn write(&mut self, node: u32, index: u16, sub: u8, value: u32) {
        let [low, high] = index.to_le_bytes();
        self.send(0x600 + node, &[&[0x23, low, high, sub], &value.to_le_bytes()[..]].concat());
        self.send(0x580 + node, &[0x60, low, high, sub, 0, 0, 0, 0]);
    }

    fn read(&mut self, node: u32, index: u16, sub: u8, value: u32) {
        let [low, high] = index.to_le_bytes();
        self.send(0x600 + node, &[0x40, low, high, sub, 0, 0, 0, 0]);
        self.send(0x580 + node, &[&[0x43, low, high, sub], &value.to_le_bytes()[..]].concat());
    }
}

/// Everything that the analyzer can tell of a frame, as text.
fn told(network: &Network, record: &Record, decoded: &Decoded) -> String {
    let bus = network.bus(record.channel).unwrap();
    let meaning = Meaning::new(record, decoded, bus);
    let signals: Vec<String> = meaning.signals().map(|signal| format!("{:?}", signal.value())).collect();
    format!("{decoded:?} {:?} {meaning} {signals:?}", bus.events())
}

/// A network; for every other seed, one node has a description.
fn network(seed: u64) -> Network {
    static SENDIX: LazyLock<DeviceDescription> = LazyLock::new(|| {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../conformance/device/models/kuebler-sendix-58x8.eds");
        eds::read(&std::fs::read(path).unwrap()).unwrap()
    });
    let mut network = Network::new();
    if seed % 2 == 1 {
        network.describe(NodeId::new(2).unwrap(), KnownDevice::described(SENDIX.clone()));
    }
    network
}

/// Decodes all frames in one network, and only those that are not skipped in a second one. Returns the number of
/// skipped frames.
fn compare<'a>(records: impl Iterator<Item = &'a Record>, seed: u64) -> usize {
    let (mut whole, mut other) = (network(seed), network(seed));
    let (mut skipping, mut skipped) = (Skipping::default(), 0);
    let mut random = Random(seed | 1);
    for record in records {
        let decoded = whole.handle(record);
        if skipping.set().skips(record) {
            let bus = whole.bus(record.channel).unwrap();
            assert!(bus.events().is_empty(), "seed {seed}, {record:?} brings something about");
            skipped += 1;
            continue;
        }
        let again = other.handle(record);
        assert_eq!(told(&other, record, &again), told(&whole, record, &decoded), "seed {seed}, {record:?}");
        // The reader wants to see some of the frames.
        let is_unwanted = random.below(8) > 0;
        skipping.taken(other.bus(record.channel).unwrap(), record, &again, |_| is_unwanted);
    }
    skipped
}

#[test]
fn random_traffic() {
    let mut skipped = 0;
    for seed in 0..400 {
        let records = Traffic::generated(seed, 1000);
        skipped += compare(records.iter(), seed);
    }
    assert!(skipped > 100_000, "only {skipped} of 400 000 frames were skipped");
}

#[test]
fn samples() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/samples");
    let mut skipped = 0;
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let Ok(capture) = Capture::open(&path, &ReadOptions::default()) else { continue };
        let items = Merge::new(vec![capture], Naming::BySource);
        let records: Vec<Record> = items.filter_map(|(_, item)| item.ok()).collect();
        skipped += compare(records.iter(), 1);
    }
    assert!(skipped > 0);
}
