//! What was sent to the device since its starts, and what was on the bus.

use crate::stimulus::{Sequence, Start, Stimulus};
use canvass_traces::{Record, Timestamp};

/// Minimum number of the last frames that are kept as evidence.
const LONGEST_EVIDENCE: usize = 1_000;

/// The frames of a device that goes on from sequence to sequence, and where in them the last sequence began.
#[derive(Debug, Default)]
pub(crate) struct History {
    /// Whether frames are kept as evidence.
    pub keep: bool,
    /// The frames since the last start, if they are kept.
    evidence: Vec<Record>,
    /// What was sent since the last start, on a device that goes on.
    sent: Vec<Stimulus>,
    /// The stimuli and frames since the start before: a device that does not come back died of these.
    before: (Sequence, Vec<Record>),
    /// The way to the bus was interrupted in the last sequence: whether what began it was done is not known.
    pub was_interrupted: bool,
    /// Number of stimuli since the last start after which the last sequence began, or its tail.
    begun_at: usize,
    /// Number of stimuli of the last sequence before its tail: at rest, after a violation that was reported before.
    tail: usize,
    /// Number of stimuli since the last start after which the device held the values of power-on.
    settled: usize,
}

impl History {
    /// A frame was on the bus.
    pub fn note(&mut self, record: Record) {
        if self.keep {
            if self.evidence.len() >= 2 * LONGEST_EVIDENCE {
                self.evidence.drain(..LONGEST_EVIDENCE);
            }
            self.evidence.push(record);
        }
    }

    /// A frame was sent.
    pub fn send(&mut self, stimulus: Stimulus) {
        self.sent.push(stimulus);
    }

    /// The device is started: what came before is a history of its own.
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

    /// A sequence begins now, or its tail after `tail` of its stimuli.
    pub fn begin(&mut self, tail: usize) {
        (self.begun_at, self.tail) = (self.sent.len(), tail);
    }

    /// The device holds the values of power-on.
    pub fn settle(&mut self) {
        self.settled = self.sent.len();
    }

    /// What was sent since the device held the values of power-on.
    pub fn unsettled(&self) -> &[Stimulus] {
        self.sent.get(self.settled..).unwrap_or_default()
    }

    /// What was sent last, latest first.
    pub fn lately(&self) -> impl Iterator<Item = &Stimulus> {
        self.sent.iter().rev()
    }

    /// When the last frame was on the bus, if it is kept.
    pub fn last(&self) -> Timestamp {
        self.evidence.last().map_or(Timestamp::ZERO, |record| record.timestamp)
    }

    /// What was sent before the last start.
    pub fn sent_before(&self) -> &[Stimulus] {
        &self.before.0.stimuli
    }

    /// The frames since the last start, if they are kept.
    pub fn evidence(&self) -> &[Record] {
        &self.evidence
    }

    /// Takes the frames since the last start, which are not needed here any more.
    pub fn take_evidence(&mut self) -> Vec<Record> {
        std::mem::take(&mut self.evidence)
    }

    /// What was sent since the last start: all that has made the device what it is.
    pub fn since_start(&self) -> Sequence {
        Sequence { start: Start::Configured, stimuli: self.sent.clone() }
    }

    /// The stimulus of the last sequence from which on the device had violated nothing.
    pub const fn tail(&self) -> usize {
        self.tail
    }

    /// What was sent since the last start before the last sequence, or its tail.
    pub fn before_sequence(&self) -> &[Stimulus] {
        self.sent.get(..self.begun_at).unwrap_or_default()
    }

    /// What was sent since the last sequence began.
    pub fn since_sequence(&self) -> Sequence {
        let stimuli = self.sent.get(self.begun_at..).unwrap_or_default().to_vec();
        Sequence { start: Start::Configured, stimuli }
    }

    /// What was sent between the last start and the one before, and the frames.
    pub fn take_before(&mut self) -> (Sequence, Vec<Record>) {
        std::mem::take(&mut self.before)
    }
}
