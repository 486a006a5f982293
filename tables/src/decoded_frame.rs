//! A decoded frame: what the rows of all tables but `frames` are made of.

use canvass_analyzer::Meaning;
use canvass_analyzer::network::{Bus, Decoded};
use canvass_traces::{Channels, Record};

/// A frame of a capture with its decoded message. `bus` is the state of its bus, on which the meaning depends.
#[derive(Clone, Copy)]
pub struct DecodedFrame<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The frame.
    pub record: &'a Record,
    /// The channels of the capture, with their names.
    pub channels: &'a Channels,
    /// The decoded message, with its node and object.
    pub decoded: &'a Decoded,
    /// The state of the bus after this frame.
    pub bus: &'a Bus,
}

impl<'a> DecodedFrame<'a> {
    /// What the frame means, as text and as values of signals.
    pub fn meaning(&self) -> Meaning<'a> {
        Meaning::new(self.record, self.decoded, self.bus)
    }
}
