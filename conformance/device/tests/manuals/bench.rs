//! One device without a bus. Its time advances only by calls, and it can be switched off and on.

use canvass_analyzer::NodeId;
use canvass_bus::Machine;
use canvass_device::Faults;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_traces::{CanId, Duration, Frame, Timestamp};

pub struct Bench {
    pub device: Device,
    pub now: Timestamp,
}

impl Bench {
    /// A device with this node-ID and a shaft at rest, after its start; and the frames that it sent meanwhile.
    pub fn started(model: &str, node: u8) -> (Self, Vec<String>) {
        let model = Model::by_id(model).unwrap_or_else(|| panic!("no model {model}"));
        let motion = Motion::still(0x4CBA);
        let device = Device::with_motion(model, NodeId::new(node), Faults::NONE, 1, &motion);
        let mut bench = Self { device, now: Timestamp::ZERO };
        let start = bench.run(300);
        (bench, start)
    }

    /// A device with node-ID 1, after its start.
    pub fn new(model: &str) -> Self {
        Self::started(model, 1).0
    }

    fn drain(&mut self, sent: &mut Vec<String>) {
        while let Some(frame) = self.device.poll_transmit(self.now) {
            sent.push(frame.to_string());
        }
    }

    /// The frames that the device sends within `millis` milliseconds.
    pub fn run(&mut self, millis: u64) -> Vec<String> {
        let deadline = self.now + Duration::from_millis(millis);
        let mut sent = Vec::new();
        self.drain(&mut sent);
        while let Some(due) = self.device.poll_timeout().filter(|due| *due <= deadline) {
            self.now = self.now.max(due);
            self.device.handle_timeout(self.now);
            self.drain(&mut sent);
            // Time goes on with every event, as on a bus.
            self.now += Duration(1);
        }
        self.now = self.now.max(deadline);
        sent
    }

    /// Sends a frame, such as `601#40...` or `701#R`; returns the frames that the device sends in the next 40 ms.
    pub fn ask(&mut self, frame: &str) -> Vec<String> {
        let frame = parse(frame);
        self.device.handle(self.now, &frame);
        let mut sent = Vec::new();
        self.drain(&mut sent);
        sent.extend(self.run(40));
        sent
    }

    /// Sends an NMT reset command; returns the frames that the device sends until it has started.
    pub fn reset(&mut self, command: &str) -> Vec<String> {
        self.ask(&format!("000#{command}01"));
        self.run(300)
    }

    /// Switches the device off and on; returns the frames that it sends meanwhile.
    pub fn power_cycle(&mut self) -> Vec<String> {
        self.device.power_cycle(self.now);
        self.run(300)
    }

    /// Writes a number by an expedited download to node 1; the error is the abort code.
    pub fn write(&mut self, index: u16, sub: u8, value: u32, len: u8) -> Result<(), u32> {
        let [low, high] = index.to_le_bytes();
        let [a, b, c, d] = value.to_le_bytes();
        let command = 0x23 | (4 - len) << 2;
        let request = format!("601#{command:02X}{low:02X}{high:02X}{sub:02X}{a:02X}{b:02X}{c:02X}{d:02X}");
        let sent = self.ask(&request);
        let response = sent.iter().find(|frame| frame.starts_with("581#")).expect("a response");
        let bytes = parse(response);
        if bytes.bytes()[0] == 0x80 { Err(number(&bytes)) } else { Ok(()) }
    }

    /// Writes "save" and waits until the device has stored; returns the frames that it sent.
    pub fn save(&mut self) -> Vec<String> {
        let mut sent = self.ask("601#2310100173617665");
        sent.extend(self.run(4_000));
        sent
    }

    /// Reads a number by an expedited upload from node 1; the error is the abort code.
    pub fn read(&mut self, index: u16, sub: u8) -> Result<u32, u32> {
        self.read_from(1, index, sub)
    }

    pub fn read_from(&mut self, node: u8, index: u16, sub: u8) -> Result<u32, u32> {
        let [low, high] = index.to_le_bytes();
        let request = format!("{:03X}#40{low:02X}{high:02X}{sub:02X}00000000", 0x600 + u16::from(node));
        let prefix = format!("{:03X}#", 0x580 + u16::from(node));
        let sent = self.ask(&request);
        let response = sent.iter().find(|frame| frame.starts_with(&prefix)).expect("a response");
        let bytes = parse(response);
        if bytes.bytes()[0] == 0x80 { Err(number(&bytes)) } else { Ok(number(&bytes)) }
    }

    /// Reads any value from node 1, in segments if the device announces them.
    pub fn read_bytes(&mut self, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        self.read_bytes_from(1, index, sub)
    }

    pub fn read_bytes_from(&mut self, node: u8, index: u16, sub: u8) -> Result<Vec<u8>, u32> {
        let [low, high] = index.to_le_bytes();
        let (prefix, node) = (format!("{:03X}#", 0x580 + u16::from(node)), 0x600 + u16::from(node));
        let answer = |bench: &mut Self, request: &str| {
            let sent = bench.ask(&format!("{node:03X}#{request}"));
            parse(sent.iter().find(|frame| frame.starts_with(&prefix)).expect("a response"))
        };
        let first = answer(self, &format!("40{low:02X}{high:02X}{sub:02X}00000000"));
        match first.bytes()[0] {
            0x80 => return Err(number(&first)),
            0x41 => {}
            command => return Ok(first.bytes()[4..8 - usize::from(command >> 2 & 3)].to_vec()),
        }
        let (mut value, mut toggle) = (Vec::new(), 0x60);
        loop {
            let segment = answer(self, &format!("{toggle:02X}00000000000000"));
            let command = segment.bytes()[0];
            value.extend_from_slice(&segment.bytes()[1..8 - usize::from(command >> 1 & 7)]);
            if command & 1 != 0 {
                assert_eq!(value.len(), number(&first) as usize, "as announced");
                return Ok(value);
            }
            toggle ^= 0x10;
        }
    }
}

/// The number in bytes 4 to 7 of a frame.
fn number(frame: &Frame) -> u32 {
    let bytes = frame.bytes();
    u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]])
}

/// Parses a frame in candump's notation: `601#40006000`, `701#R`.
pub fn parse(text: &str) -> Frame {
    let (id, data) = text.split_once('#').unwrap();
    let id = CanId::standard(u32::from_str_radix(id, 16).unwrap()).unwrap();
    if data.starts_with('R') {
        return Frame::remote(id, 1).unwrap();
    }
    let digits: String = data.chars().filter(|digit| !digit.is_whitespace()).collect();
    let bytes: Vec<u8> =
        (0..digits.len() / 2).map(|n| u8::from_str_radix(&digits[2 * n..2 * n + 2], 16).unwrap()).collect();
    Frame::new(id, &bytes).unwrap()
}
