//! A decoded frame: what the rows of all tables but `frames` are made of.

use canvass_analyzer::Meaning;
use canvass_analyzer::network::{Bus, Decoded};
use canvass_traces::{Channels, Record};

/// A frame of a capture with its meaning, and the bus that gives it.
#[derive(Clone, Copy)]
pub struct DecodedFrame<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The frame.
    pub record: &'a Record,
    /// The channels of the capture, with their names.
    pub channels: &'a Channels,
    /// The decoded meaning of the frame.
    pub decoded: &'a Decoded,
    /// The state of the bus after this frame.
    pub bus: &'a Bus,
}

impl<'a> DecodedFrame<'a> {
    /// The meaning of the frame, for text and values.
    pub fn meaning(&self) -> Meaning<'a> {
        Meaning::new(self.record, self.decoded, self.bus)
    }
}
