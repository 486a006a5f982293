//! A simulated bus with one device, driven by frames in candump's notation.

use canvass_analyzer::NodeId;
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_traces::{CanId, Direction, Duration, Frame, Record, Timestamp};

pub struct Rig {
    pub bus: SimulatedBus,
}

pub fn model() -> &'static Model {
    Model::by_id("kuebler-sendix-58x8").unwrap()
}

impl Rig {
    /// A bus with node 63 at 250 kbit/s, after the boot-up message.
    pub fn new() -> Self {
        Self::with(Faults::NONE)
    }

    pub fn with(faults: impl Into<Faults>) -> Self {
        let mut rig = Self::powered(model(), Some(63), faults.into(), &Motion::still(0x4CBA));
        rig.run(300);
        rig
    }

    pub fn powered(model: &Model, node: Option<u8>, faults: Faults, motion: &Motion) -> Self {
        Self::powered_at(250_000, model, node, faults, motion)
    }

    /// A bus with this bit rate. A device without a bit rate of its own uses that of the bus.
    pub fn powered_at(bit_rate: u32, model: &Model, node: Option<u8>, faults: Faults, motion: &Motion) -> Self {
        let mut bus = SimulatedBus::new(bit_rate);
        let node = node.map(|node| NodeId::new(node).unwrap());
        bus.attach(Box::new(Device::with_motion(model, node, faults, 1, motion)));
        Self { bus }
    }

    pub fn send(&mut self, frame: &str) {
        self.bus.send(&parse(frame)).unwrap();
    }

    /// All frames that the device sends within `millis` milliseconds.
    pub fn records(&mut self, millis: u64) -> Vec<Record> {
        let deadline = self.bus.now() + Duration::from_millis(millis);
        let mut records = Vec::new();
        while let Some(record) = self.bus.receive(deadline).unwrap() {
            if record.direction == Direction::Rx {
                records.push(record);
            }
        }
        records
    }

    /// All frames that the device sends within `millis` milliseconds, as text.
    pub fn run(&mut self, millis: u64) -> Vec<String> {
        self.records(millis).iter().map(|record| record.frame.to_string()).collect()
    }

    /// Sends a frame; returns all frames that the device sends in the next 50 ms.
    pub fn ask(&mut self, frame: &str) -> Vec<String> {
        self.send(frame);
        self.run(50)
    }

    /// All frames that the device sends in the next 50 ms.
    pub fn ask_nothing(&mut self) -> Vec<String> {
        self.run(50)
    }

    /// Sends SDO requests. Each request must have the one response that follows it in `pairs`.
    pub fn dialogue(&mut self, pairs: &[(&str, &str)]) {
        for (request, response) in pairs {
            assert_eq!(self.ask(&format!("63F#{request}")), [format!("5BF#{response}")], "to {request}");
        }
    }

    /// Writes a number by an expedited download; returns `ok` or the abort code.
    pub fn write(&mut self, index: u16, sub: u8, value: u32, len: usize) -> String {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let command = 0x23 | (4 - len as u8) << 2;
        let frame = format!("63F#{command:02X}{low:02X}{high:02X}{sub:02X}{a:02X}{b:02X}{c:02X}{d:02X}");
        let answer = self.ask(&frame);
        match answer.iter().find(|frame| frame.starts_with("5BF#")).map(|frame| &frame[4..]) {
            Some(response) if response.starts_with("60") => "ok".to_owned(),
            Some(response) => abort_code(response),
            None => "silence".to_owned(),
        }
    }

    /// Reads a number by an expedited upload; the error is the abort code.
    pub fn read(&mut self, index: u16, sub: u8) -> Result<u32, String> {
        let [low, high] = index.to_le_bytes();
        self.send(&format!("63F#40{low:02X}{high:02X}{sub:02X}00000000"));
        let records = self.records(50);
        let response = records.iter().find(|record| record.frame.cob_id() == Some(0x5BF));
        let Some(response) = response else { return Err("silence".to_owned()) };
        let bytes = response.frame.bytes();
        match bytes[0] {
            0x80 => Err(abort_code(&response.frame.to_string()[4..])),
            _ => Ok(u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]])),
        }
    }
}

/// The abort code in the eight bytes of an abort, such as `06020000`.
fn abort_code(response: &str) -> String {
    assert!(response.starts_with("80"), "{response}");
    (0..4).rev().map(|n| &response[8 + 2 * n..10 + 2 * n]).collect()
}

/// Parses a frame in candump's notation: `63F#40006000`, `73F#R1`.
pub fn parse(text: &str) -> Frame {
    let (id, data) = text.split_once('#').unwrap();
    let raw = u32::from_str_radix(id, 16).unwrap();
    let id = if id.len() == 8 { CanId::extended(raw) } else { CanId::standard(raw) }.unwrap();
    if let Some(len) = data.strip_prefix('R') {
        return Frame::remote(id, len.parse().unwrap_or(0)).unwrap();
    }
    let bytes: Vec<u8> =
        (0..data.len() / 2).map(|n| u8::from_str_radix(&data[2 * n..2 * n + 2], 16).unwrap()).collect();
    Frame::new(id, &bytes).unwrap()
}

/// The times between records, in milliseconds.
pub fn periods(records: &[Record]) -> Vec<f64> {
    records.windows(2).map(|pair| pair[1].timestamp.since(pair[0].timestamp).as_millis()).collect()
}

/// A deadline that this bus never reaches.
pub const NEVER: Timestamp = Timestamp::MAX;
