//! A violation with the sequence that shows it, and the proof that it comes back.

use crate::baseline::Kept;
use crate::oracle::Violation;
use crate::stimulus::{Sequence, Stimulus};
use canvass_traces::{Duration, Record};

/// A violation with the shortest sequence that shows it.
#[derive(Clone, Debug)]
pub struct Found {
    /// The violated property, the expected and the actual behaviour.
    pub violation: Violation,
    /// The frames before the sequence, with a reset at their end. Empty if a new device was made for each repetition.
    pub prelude: Vec<Stimulus>,
    /// The shortest sequence found that shows the violation.
    pub sequence: Sequence,
    /// All frames on the bus during the sequence, including the device's.
    pub evidence: Vec<Record>,
    /// Whether the violation came again in each repetition from the same start. If not, sequence and evidence are
    /// those of its only occurrence.
    pub confirmed: bool,
    /// The repetitions, each from a start.
    pub repetitions: Vec<Repetition>,
    /// Whether the violation came back only when all frames since a start were sent again: these are the sequence.
    pub needs_earlier: bool,
    /// Whether the device was reset for each repetition, and not made anew.
    pub is_live: bool,
    /// The time after which an answer came that had been missing. The device or this machine was late.
    pub late: Option<Duration>,
    /// Number of sequences of the run that have shown the violation, without its repetitions.
    pub times: u64,
    /// Objects without their power-on values when the violation was seen: neither a reset nor a write had restored
    /// them. These objects are also changed when the sequence is repeated.
    pub state: Vec<Kept>,
    /// Whether the bus was lost before the sequence could be repeated.
    pub is_cut_off: bool,
}

impl Found {
    /// A violation that was seen, and not repeated yet.
    pub fn seen(violation: Violation, sequence: Sequence, evidence: Vec<Record>) -> Self {
        Self {
            violation,
            prelude: Vec::new(),
            sequence,
            evidence,
            confirmed: false,
            repetitions: Vec::new(),
            needs_earlier: false,
            is_live: false,
            late: None,
            times: 1,
            state: Vec::new(),
            is_cut_off: false,
        }
    }

    /// All frames of a repetition: those before the sequence, and the sequence.
    pub fn whole(&self) -> Sequence {
        Sequence {
            start: self.sequence.start,
            stimuli: self.prelude.iter().chain(&self.sequence.stimuli).copied().collect(),
        }
    }

    /// Whether a player that sends the frames at the times of the log, without waiting for answers, shows the violation.
    pub fn shows_by_times(&self) -> bool {
        let mut by_times = self.repetitions.iter().filter(|repetition| repetition.replay == Replay::Times).peekable();
        by_times.peek().is_some() && by_times.all(|repetition| repetition.shows)
    }
}

/// A repetition of a sequence.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Repetition {
    /// When the next frame was sent.
    pub replay: Replay,
    /// Whether the violation came.
    pub shows: bool,
    /// The behaviour of the device: the wrong answer, or "no violation".
    pub came: String,
}

/// When the next frame of a sequence is sent.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Replay {
    /// When the device has answered, as `canvass fuzz --replay` does.
    Answers,
    /// At its time in the log, as `canplayer` does.
    Times,
}

impl Replay {
    /// The name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Answers => "answers",
            Self::Times => "times",
        }
    }
}
