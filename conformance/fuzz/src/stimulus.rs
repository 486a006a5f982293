//! The input of a device: frames, and the waits between them.

use canvass_traces::{Duration, Frame};

/// The pause in a log after a frame that the device gets time to answer.
pub(crate) const SETTLE: Duration = Duration::from_millis(100);

/// A frame and the wait after it.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Stimulus {
    /// The frame to send.
    pub frame: Frame,
    /// The wait before the next frame.
    pub then: Then,
}

/// The wait before the next frame.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Then {
    /// Until the device has answered as required, or the time for the answer is over.
    Settle,
    /// At once: the device gets no time between the two frames.
    AtOnce,
    /// A fixed time, in which frames of the device are judged.
    Pause(Duration),
}

impl Stimulus {
    /// A frame that the device gets time to answer.
    pub const fn settle(frame: Frame) -> Self {
        Self { frame, then: Then::Settle }
    }
}

/// The state of the device at the beginning of a sequence.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub enum Start {
    /// With its node-ID, just booted, in pre-operational.
    #[default]
    Configured,
    /// Without node-ID, so that only LSS works.
    Unconfigured,
}

/// A start, and frames that are sent one after the other.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Sequence {
    /// The state in which the sequence begins.
    pub start: Start,
    /// The frames in their order.
    pub stimuli: Vec<Stimulus>,
}
