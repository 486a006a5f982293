//! What the fuzzer does to a device: frames, and how long it waits after each.

use canvass_traces::{Duration, Frame};

/// A frame and what follows it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Stimulus {
    /// The frame that is sent.
    pub frame: Frame,
    /// When the next one follows.
    pub then: Then,
}

/// When the next frame follows.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Then {
    /// Once the device has answered as it must, or the time for that is over.
    Settle,
    /// At once: the device gets no time between the two.
    AtOnce,
    /// After that time; frames of the device are judged meanwhile.
    Pause(Duration),
}

impl Stimulus {
    /// A frame that the device gets time to answer.
    pub const fn settle(frame: Frame) -> Self {
        Self { frame, then: Then::Settle }
    }
}

/// In which condition a sequence finds the device.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Start {
    /// With its node-ID, just booted, in pre-operational.
    #[default]
    Configured,
    /// Without node-ID: only LSS works.
    Unconfigured,
}

/// One try: from a start, one frame after the other.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Sequence {
    /// How it begins.
    pub start: Start,
    /// What is done, in order.
    pub stimuli: Vec<Stimulus>,
}
