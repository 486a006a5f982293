//! A null device on the bus: it answers in place of a right device, or passes frames on to it.

use super::NullDevice;
use super::answers::{Answers, Reaction};
use canvass_analyzer::NodeId;
use canvass_bus::Machine;
use canvass_device::Device;
use canvass_traces::{Frame, Timestamp};
use std::collections::VecDeque;

/// A null device.
#[derive(Clone)]
pub(super) struct NullMachine {
    /// A right device. It receives and sends only the frames that the null device passes on.
    base: Device,
    answers: Answers,
    outbox: VecDeque<Frame>,
}

impl NullMachine {
    pub fn new(kind: NullDevice, node: NodeId, base: Device) -> Self {
        Self { base, answers: Answers::new(kind, node), outbox: VecDeque::new() }
    }
}

impl Machine for NullMachine {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        match self.answers.react(frame) {
            Reaction::Passed => self.base.handle(now, frame),
            Reaction::Answered(answers) => self.outbox.extend(answers),
        }
    }

    fn poll_transmit(&mut self, now: Timestamp) -> Option<Frame> {
        if let Some(frame) = self.outbox.pop_front() {
            return Some(frame);
        }
        while let Some(frame) = self.base.poll_transmit(now) {
            if let Some(frame) = self.answers.on_send(frame) {
                return Some(frame);
            }
        }
        None
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        self.base.poll_timeout()
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        self.base.handle_timeout(now);
    }

    fn bit_rate(&self) -> Option<u32> {
        self.base.bit_rate()
    }

    fn power_cycle(&mut self, now: Timestamp) {
        self.outbox.clear();
        Machine::power_cycle(&mut self.base, now);
    }

    fn duplicate(&self) -> Option<Box<dyn Machine>> {
        Some(Box::new(self.clone()))
    }

    fn withdraws(&self, pending: &Frame) -> bool {
        self.base.withdraws(pending)
    }
}
