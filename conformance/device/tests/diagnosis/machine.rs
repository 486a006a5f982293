//! A master and one simulated device, with a record of all frames on their bus.

use canvass_analyzer::findings::{Diagnosis, Finding, SourceQuality, Thresholds};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::{Bus, SimulatedBus};
use canvass_device::Firmware;
use canvass_device::models::Model;
use canvass_device::{Device, Motion};
use canvass_traces::{CanId, Duration, Frame, Quality, Record, Timestamp};

pub struct Machine {
    pub model: &'static Model,
    pub node: NodeId,
    pub records: Vec<Record>,
    bus: SimulatedBus,
    /// Whether the master sends SYNC every 20 ms.
    pub syncs: bool,
    /// Whether the master guards the node every 300 ms.
    pub guards: bool,
    next_sync: Timestamp,
    next_guard: Timestamp,
}

/// The node-ID for devices that are delivered without one.
const GIVEN: u8 = 63;

pub fn frame(id: u16, bytes: &[u8]) -> Frame {
    Frame::new(CanId::standard(u32::from(id)).unwrap(), bytes).unwrap()
}

impl Machine {
    /// Switches a device on; its shaft makes one revolution per second.
    pub fn new(model: &'static Model, firmware: impl Into<Firmware>) -> Self {
        let node = model.default_node().unwrap_or_else(|| NodeId::new(GIVEN).unwrap());
        let mut bus = SimulatedBus::new(model.default_bit_rate());
        let motion = Motion::constant(1_000, 60_000);
        bus.attach(Box::new(Device::with_motion(model, Some(node), firmware, 7, &motion)));
        let zero = Timestamp::ZERO;
        let mut machine = Self {
            model,
            node,
            records: Vec::new(),
            bus,
            syncs: false,
            guards: false,
            next_sync: zero,
            next_guard: zero,
        };
        machine.run(1_500);
        machine
    }

    fn id(&self, base: u16) -> u16 {
        base + u16::from(self.node.raw())
    }

    pub fn send(&mut self, id: u16, bytes: &[u8]) {
        self.bus.send(&frame(id, bytes)).unwrap();
    }

    /// Runs until a frame is `wanted`, but at most `millis` milliseconds.
    fn until(&mut self, millis: u64, wanted: impl Fn(&Record) -> bool) -> Option<Record> {
        let end = self.bus.now() + Duration::from_millis(millis);
        loop {
            let now = self.bus.now();
            if self.syncs && now >= self.next_sync {
                self.send(0x080, &[]);
                self.next_sync = now.max(self.next_sync) + Duration::from_millis(20);
            }
            if self.guards && now >= self.next_guard {
                let poll = Frame::remote(CanId::standard(u32::from(self.id(0x700))).unwrap(), 1).unwrap();
                self.bus.send(&poll).unwrap();
                self.next_guard = now.max(self.next_guard) + Duration::from_millis(300);
            }
            let mut deadline = end;
            deadline = if self.syncs { deadline.min(self.next_sync) } else { deadline };
            deadline = if self.guards { deadline.min(self.next_guard) } else { deadline };
            while let Some(record) = self.bus.receive(deadline).unwrap() {
                self.records.push(record.clone());
                if wanted(&record) {
                    return Some(record);
                }
            }
            if self.bus.now() >= end {
                return None;
            }
        }
    }

    pub fn run(&mut self, millis: u64) {
        self.until(millis, |_| false);
    }

    /// Sends a request to the SDO server; returns the answer.
    pub fn ask(&mut self, request: [u8; 8]) -> Option<[u8; 8]> {
        let (client, server) = (self.id(0x600), self.id(0x580));
        self.send(client, &request);
        let answer = self.until(6_000, |record| record.frame.cob_id() == Some(server));
        self.run(7);
        answer.map(|record| record.frame.bytes().to_owned())
    }

    /// Whether the device has this object, and the object can be written.
    pub fn has_writable(&self, index: u16, sub: u8) -> bool {
        use canvass_analyzer::dictionary::Access;
        let entry = self.model.description().dictionary.entry(Multiplexer::new(index, sub));
        entry.is_ok_and(|entry| matches!(entry.access, Access::Rw | Access::Rww | Access::Rwr))
    }

    /// Reads an object of any length, if the device has it.
    pub fn read(&mut self, index: u16, sub: u8) -> Option<u32> {
        if self.model.description().dictionary.entry(Multiplexer::new(index, sub)).is_err() {
            return None;
        }
        let [low, high] = index.to_le_bytes();
        let answer = self.ask([0x40, low, high, sub, 0, 0, 0, 0])?;
        // The server may announce an upload in segments.
        let mut more = answer[0] & 0xE2 == 0x40;
        let mut toggle = 0;
        while more {
            let segment = self.ask([0x60 | toggle, 0, 0, 0, 0, 0, 0, 0])?;
            more = segment[0] & 0xE1 == 0;
            toggle ^= 0x10;
        }
        Some(u32::from_le_bytes([answer[4], answer[5], answer[6], answer[7]]))
    }

    /// Writes a number of `length` bytes.
    pub fn write(&mut self, index: u16, sub: u8, value: u32, length: u8) {
        let ([low, high], [a, b, c, d]) = (index.to_le_bytes(), value.to_le_bytes());
        self.ask([0x23 | (4 - length) << 2, low, high, sub, a, b, c, d]);
    }

    /// Sends an NMT command to the node.
    pub fn command(&mut self, command: u8) {
        self.send(0x000, &[command, self.node.raw()]);
        self.run(1);
    }

    /// The findings of the diagnosis; with `described`, the diagnosis knows the description of the model.
    pub fn findings(&self, described: bool) -> Vec<Finding> {
        let mut diagnosis = Diagnosis::new(Thresholds::default());
        if described {
            diagnosis.describe(self.node, canvass_analyzer::dictionary::KnownDevice::clone(self.model.device()));
        }
        let mut quality = Quality::default();
        for record in &self.records {
            quality.record(record);
            diagnosis.record(record);
        }
        diagnosis.finish(&[SourceQuality { name: "simulated", quality: &quality }]).findings
    }
}

pub fn shown(finding: &Finding) -> String {
    let at = finding.first.nanos() / 1_000_000;
    format!("{at} ms {} {:?}: {} ({} times)", finding.rule.id, finding.node, finding.message, finding.count)
}
