//! The frames sent to the device since its last starts, and the frames on the bus.

use crate::stimulus::{Sequence, Start, Stimulus};
use canvass_traces::{Record, Timestamp};

/// Minimum number of the last frames that are kept as evidence.
const LONGEST_EVIDENCE: usize = 1_000;

/// The frames of a device that is not made anew for each sequence, and the position at which the last sequence began.
/// If a sequence goes on after a violation that was reported before, the rest of it is its *tail*, which begins at
/// rest.
#[derive(Debug, Default)]
pub(crate) struct History {
    /// Whether frames are kept as evidence.
    pub keep: bool,
    /// The frames since the last start, if they are kept.
    evidence: Vec<Record>,
    /// The stimuli since the last start, on a live device.
    sent: Vec<Stimulus>,
    /// The stimuli and frames between the last two starts: the cause if the device does not come back.
    before: (Sequence, Vec<Record>),
    /// Whether the connection to the bus was interrupted in the last sequence, so that its start may not have happened.
    pub was_interrupted: bool,
    /// Number of stimuli between the last start and the beginning of the last sequence or, if the sequence has a tail,
    /// of its tail.
    begun_at: usize,
    /// Number of stimuli of the last sequence before its tail; 0 without a tail.
    tail: usize,
    /// Number of stimuli from the last start to the last moment at which the device held its power-on values.
    settled: usize,
}

impl History {
    /// Adds a frame that was on the bus.
    pub fn note(&mut self, record: Record) {
        if self.keep {
            if self.evidence.len() >= 2 * LONGEST_EVIDENCE {
                self.evidence.drain(..LONGEST_EVIDENCE);
            }
            self.evidence.push(record);
        }
    }

    /// Adds a stimulus that was sent.
    pub fn send(&mut self, stimulus: Stimulus) {
        self.sent.push(stimulus);
    }

    /// Begins a new history with a start. The frames up to now are kept as the history of the previous start.
    pub fn start(&mut self, is_repeatable: bool) {
        let evidence = std::mem::take(&mut self.evidence);
        if !is_repeatable {
            let stimuli = std::mem::take(&mut self.sent);
            if !std::mem::take(&mut self.was_interrupted) {
                self.before = (Sequence::default(), Vec::new());
            }
            self.before.0.stimuli.extend(stimuli);
            self.before.1.extend(evidence);
        }
        (self.begun_at, self.settled) = (0, 0);
    }

    /// Begins a sequence, or its tail after `tail` stimuli.
    pub fn begin(&mut self, tail: usize) {
        (self.begun_at, self.tail) = (self.sent.len(), tail);
    }

    /// Records that the device holds its power-on values.
    pub fn settle(&mut self) {
        self.settled = self.sent.len();
    }

    /// The stimuli since the device held its power-on values.
    pub(crate) fn unsettled(&self) -> &[Stimulus] {
        self.sent.get(self.settled..).unwrap_or_default()
    }

    /// The stimuli since the last start, latest first.
    pub fn lately(&self) -> impl Iterator<Item = &Stimulus> {
        self.sent.iter().rev()
    }

    /// The time of the last frame, if it is kept.
    pub fn last(&self) -> Timestamp {
        self.evidence.last().map_or(Timestamp::ZERO, |record| record.timestamp)
    }

    /// The stimuli before the last start.
    pub(crate) fn sent_before(&self) -> &[Stimulus] {
        &self.before.0.stimuli
    }

    /// The frames since the last start, if they are kept.
    pub fn evidence(&self) -> &[Record] {
        &self.evidence
    }

    /// Takes the frames since the last start out of the history.
    pub fn take_evidence(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.evidence)
    }

    /// All stimuli since the last start. They determine the state of the device.
    pub fn since_start(&self) -> Sequence {
        Sequence { start: Start::Configured, stimuli: self.sent.clone() }
    }

    /// Number of stimuli of the last sequence before its tail. Since then the device has violated nothing.
    pub const fn tail(&self) -> usize {
        self.tail
    }

    /// The stimuli between the last start and the last sequence, or its tail.
    pub(crate) fn before_sequence(&self) -> &[Stimulus] {
        self.sent.get(..self.begun_at).unwrap_or_default()
    }

    /// The stimuli since the last sequence, or its tail, began.
    pub(crate) fn since_sequence(&self) -> Sequence {
        let stimuli = self.sent.get(self.begun_at..).unwrap_or_default().to_vec();
        Sequence { start: Start::Configured, stimuli }
    }

    /// Takes the stimuli and frames between the last two starts.
    pub(crate) fn take_before(&mut self) -> (Sequence, Vec<Record>) {
        std::mem::take(&mut self.before)
    }
}
