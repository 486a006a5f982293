//! A device that can die: it then neither accepts nor sends a frame.

use canvass_bus::Machine;
use canvass_device::Device;
use canvass_traces::{Frame, Timestamp};

pub struct Perishable {
    pub device: Device,
    pub dead: bool,
}

impl Perishable {
    pub fn new(device: Device) -> Self {
        Self { device, dead: false }
    }
}

impl Machine for Perishable {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        if !self.dead {
            self.device.handle(now, frame);
        }
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        if self.dead { None } else { self.device.poll_transmit(now) }
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        if self.dead { None } else { self.device.poll_timeout() }
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if !self.dead {
            self.device.handle_timeout(now);
        }
    }
}
