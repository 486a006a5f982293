//! Makes a sequence shorter as long as it still shows the violation.
//!
//! Most violations need only the last frames, so these are tried first: none, one, two, four and so on. These tries take the
//! least time. Then all pauses are removed at once, so that later tries take less time. Then stretches of frames are
//! removed, from half of the sequence down to single frames, until no single frame can be left out. Then stretches are
//! replaced by waits, as their only effect may have been to take time. Last, the frames are made plainer, all at once
//! if possible, otherwise one by one: waits are shortened, and bytes are set to 0.

use super::stimulus::{Sequence, Stimulus, Then};
use canvass_traces::{Duration, Frame};
use proptest::strategy::ValueTree;
use std::ops::Range;

/// Maximum length of a dialogue whose frames can only be removed together, such as a block upload.
const DIALOGUE: usize = 4;

/// A sequence and its simpler variants.
#[derive(Clone, Debug)]
pub struct SequenceTree {
    /// The simplest sequence that is known to show the violation.
    best: Sequence,
    /// The variant that is being tried. `None`: the simplest sequence itself.
    variant: Option<Sequence>,
    step: ShrinkStep,
    /// Whether a variant was accepted since the steps began anew.
    progress: bool,
}

/// The next simplification to try.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum ShrinkStep {
    /// Keep only the last `length` frames.
    Last {
        length: usize,
    },
    /// Wait no longer than needed after each frame.
    NoPauses,
    /// Leave out `length` frames, beginning with frame `from`.
    Remove {
        length: usize,
        from: usize,
    },
    /// Wait instead of sending `length` frames after frame `from`.
    Wait {
        length: usize,
        from: usize,
    },
    /// Wait no longer than needed after each frame, and set the last four bytes of each to 0.
    Plain,
    /// Wait no longer than needed after frame `at`.
    Settle {
        at: usize,
    },
    /// Set one byte of frame `at` to 0.
    Zero {
        at: usize,
        byte: usize,
    },
    Done,
}

impl SequenceTree {
    /// A tree for a sequence whose simpler variants are to be tried.
    pub fn new(sequence: Sequence) -> Self {
        Self { best: sequence, variant: None, step: ShrinkStep::Last { length: 0 }, progress: false }
    }

    /// The simplest sequence that is known to show the violation.
    pub fn best(&self) -> &Sequence {
        &self.best
    }

    /// The variant that is being tried.
    pub fn tried(&self) -> &Sequence {
        self.variant.as_ref().unwrap_or(&self.best)
    }

    /// Returns to the variant that was to be tried, or makes the next variant. `false` if there is none.
    pub(super) fn go_on(&mut self) -> bool {
        self.variant.is_some() || self.advance()
    }

    /// Makes the next variant. `false` if there is none.
    fn advance(&mut self) -> bool {
        loop {
            if self.step == ShrinkStep::Done {
                self.variant = None;
                return false;
            }
            let variant = self.simpler();
            self.step = self.next_step();
            if variant.is_some() {
                self.variant = variant;
                return true;
            }
        }
    }

    /// The simplest sequence with the current step applied, if this changes anything.
    fn simpler(&self) -> Option<Sequence> {
        let mut variant = self.best.clone();
        match self.step {
            ShrinkStep::Last { length } => {
                let others = variant.stimuli.len().checked_sub(length).filter(|&others| others > 0)?;
                variant.stimuli.drain(..others);
            }
            ShrinkStep::NoPauses => {
                let is_pause = |stimulus: &&mut Stimulus| matches!(stimulus.then, Then::Pause(_));
                variant.stimuli.iter_mut().filter(is_pause).for_each(|stimulus| stimulus.then = Then::Settle);
                if variant.stimuli == self.best.stimuli {
                    return None;
                }
            }
            ShrinkStep::Plain => {
                variant.stimuli.iter_mut().for_each(make_plain);
                if variant.stimuli == self.best.stimuli {
                    return None;
                }
            }
            ShrinkStep::Remove { length, from } => {
                let end = (from + length).min(variant.stimuli.len());
                if from >= end {
                    return None;
                }
                variant.stimuli.drain(from..end);
            }
            ShrinkStep::Wait { length, from } => {
                let end = (from + 1 + length).min(variant.stimuli.len());
                if from + 1 >= end {
                    return None;
                }
                let pause = variant.stimuli.get(from..end)?.iter().fold(Duration::ZERO, |sum, one| sum + time_of(one));
                variant.stimuli.drain(from + 1..end);
                variant.stimuli.get_mut(from)?.then = Then::Pause(pause);
            }
            ShrinkStep::Settle { at } => {
                let stimulus = variant.stimuli.get_mut(at)?;
                if stimulus.then == Then::Settle {
                    return None;
                }
                stimulus.then = Then::Settle;
            }
            ShrinkStep::Zero { at, byte } => {
                let stimulus = variant.stimuli.get_mut(at)?;
                if stimulus.frame.data().get(byte).is_none_or(|&value| value == 0) {
                    return None;
                }
                stimulus.frame = with_zeros(&stimulus.frame, byte..byte + 1)?;
            }
            ShrinkStep::Done => return None,
        }
        Some(variant)
    }

    fn next_step(&mut self) -> ShrinkStep {
        let len = self.best.stimuli.len();
        match self.step {
            ShrinkStep::Last { length: 0 } => ShrinkStep::Last { length: 1 },
            ShrinkStep::Last { length } if length * 2 < len => ShrinkStep::Last { length: length * 2 },
            ShrinkStep::Last { .. } => ShrinkStep::NoPauses,
            ShrinkStep::NoPauses => ShrinkStep::Remove { length: len.div_ceil(2).max(1), from: 0 },
            ShrinkStep::Remove { length, from } if from + length < len => {
                ShrinkStep::Remove { length, from: from + stride(length) }
            }
            ShrinkStep::Wait { length, from } if from + 1 + length < len => {
                ShrinkStep::Wait { length, from: from + stride(length) }
            }
            ShrinkStep::Remove { length, .. } if length > 1 => {
                ShrinkStep::Remove { length: length.div_ceil(2), from: 0 }
            }
            ShrinkStep::Remove { .. } | ShrinkStep::Wait { length: ..=1, .. } if self.progress => self.restart(),
            ShrinkStep::Remove { .. } => ShrinkStep::Wait { length: len.saturating_sub(1).max(1), from: 0 },
            ShrinkStep::Wait { length: ..=1, .. } => ShrinkStep::Plain,
            ShrinkStep::Plain => ShrinkStep::Settle { at: 0 },
            ShrinkStep::Wait { length, .. } => ShrinkStep::Wait { length: length.div_ceil(2), from: 0 },
            ShrinkStep::Settle { at } if at + 1 < len => ShrinkStep::Settle { at: at + 1 },
            ShrinkStep::Settle { .. } => ShrinkStep::Zero { at: 0, byte: 4 },
            ShrinkStep::Zero { at, byte } if byte < 7 => ShrinkStep::Zero { at, byte: byte + 1 },
            ShrinkStep::Zero { at, .. } if at + 1 < len => ShrinkStep::Zero { at: at + 1, byte: 4 },
            ShrinkStep::Zero { .. } | ShrinkStep::Done => ShrinkStep::Done,
        }
    }

    /// Begins the steps anew with dialogues and single frames. A frame that was needed before may be superfluous now.
    fn restart(&mut self) -> ShrinkStep {
        self.progress = false;
        ShrinkStep::Remove { length: DIALOGUE, from: 0 }
    }

    /// Sets the next step after a variant that showed the violation, considering that frames may have moved up.
    fn accepted(&mut self) {
        self.progress = true;
        match &mut self.step {
            // The frames before the kept end are gone already, so that longer ends need no try.
            ShrinkStep::Last { .. } => self.step = ShrinkStep::NoPauses,
            ShrinkStep::Remove { length, from } | ShrinkStep::Wait { length, from } => {
                *from = from.saturating_sub(stride(*length));
            }
            _ => {}
        }
    }
}

/// Sets the shortest wait, and sets the last four of eight bytes to 0.
fn make_plain(stimulus: &mut Stimulus) {
    stimulus.then = Then::Settle;
    if let Some(frame) = with_zeros(&stimulus.frame, 4..8) {
        stimulus.frame = frame;
    }
}

/// The frame with 0 in the bytes of the range that it has. `None` for a remote frame.
fn with_zeros(frame: &Frame, bytes: Range<usize>) -> Option<Frame> {
    if frame.is_remote() {
        return None;
    }
    let (mut data, length) = (frame.bytes(), frame.data().len().min(8));
    data.get_mut(bytes)?.fill(0);
    Frame::new(frame.id(), &data[..length])
}

/// The approximate time that a frame and its answer take.
const fn time_of(stimulus: &Stimulus) -> Duration {
    match stimulus.then {
        Then::AtOnce => Duration::from_millis(1),
        Then::Settle => Duration::from_millis(10),
        Then::Pause(pause) => pause,
    }
}

/// The distance between the beginnings of two stretches. Stretches of a dialogue's length may begin at each frame.
const fn stride(length: usize) -> usize {
    if length <= DIALOGUE { 1 } else { length }
}

impl ValueTree for SequenceTree {
    type Value = Sequence;

    fn current(&self) -> Sequence {
        self.tried().clone()
    }

    /// Accepts the current variant, which shows the violation.
    fn simplify(&mut self) -> bool {
        if let Some(variant) = self.variant.take() {
            self.best = variant;
            self.accepted();
        }
        self.advance()
    }

    /// Rejects the current variant, which does not show the violation.
    fn complicate(&mut self) -> bool {
        self.advance()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_traces::{CanId, Duration};

    fn sequence(ids: &[u32]) -> Sequence {
        let stimulus = |&id: &u32| Stimulus {
            frame: Frame::new(CanId::standard_masked(id), &[1, 2, 3, 4, 5, 6, 7, 8]).unwrap(),
            then: Then::Pause(Duration::from_millis(80)),
        };
        Sequence { stimuli: ids.iter().map(stimulus).collect(), ..Sequence::default() }
    }

    fn shrink(start: Sequence, shows: impl Fn(&[u32]) -> bool) -> Sequence {
        let mut tree = SequenceTree::new(start);
        let mut tries = 0;
        let mut more = true;
        while more {
            let ids: Vec<u32> = tree.current().stimuli.iter().map(|stimulus| stimulus.frame.id().raw()).collect();
            more = if shows(&ids) { tree.simplify() } else { tree.complicate() };
            tries += 1;
            assert!(tries < 5_000, "no end");
        }
        tree.best().clone()
    }

    /// All needed frames are kept in their order, and no other frame.
    #[test]
    fn what_is_not_needed_goes() {
        let all: Vec<u32> = (0..40).collect();
        for needed in [vec![7], vec![0, 39], vec![3, 4, 5], vec![12, 31, 38]] {
            let minimal = shrink(sequence(&all), |ids| {
                let kept: Vec<u32> = ids.iter().copied().filter(|id| needed.contains(id)).collect();
                kept == needed
            });
            let ids: Vec<u32> = minimal.stimuli.iter().map(|stimulus| stimulus.frame.id().raw()).collect();
            assert_eq!(ids, needed);
            for stimulus in &minimal.stimuli {
                assert_eq!(stimulus.frame.data(), [1, 2, 3, 4, 0, 0, 0, 0]);
                assert_eq!(stimulus.then, Then::Settle);
            }
        }
    }

    /// If the last frames alone show the violation, few tries are needed, however long the sequence is.
    #[test]
    fn the_end_of_a_long_sequence_is_tried_first() {
        let all: Vec<u32> = (0..800).collect();
        let mut tree = SequenceTree::new(sequence(&all));
        let (mut tries, mut sent, mut more) = (0, 0, tree.simplify());
        while more {
            let ids: Vec<u32> = tree.current().stimuli.iter().map(|stimulus| stimulus.frame.id().raw()).collect();
            (tries, sent) = (tries + 1, sent + ids.len());
            more = if ids.ends_with(&[797, 799]) || ids.ends_with(&[797, 798, 799]) {
                tree.simplify()
            } else {
                tree.complicate()
            };
        }
        assert_eq!(tree.best().stimuli.len(), 2);
        assert!(tries <= 20 && sent <= 60, "{tries} tries, {sent} frames");
    }

    #[test]
    fn what_only_takes_time_becomes_a_wait() {
        let mut tree = SequenceTree::new(sequence(&(0..20).collect::<Vec<_>>()));
        let mut more = true;
        while more {
            let stimuli = tree.current().stimuli;
            let time = stimuli.iter().fold(Duration::ZERO, |sum, one| sum + time_of(one));
            more = if time >= Duration::from_millis(900) { tree.simplify() } else { tree.complicate() };
        }
        let minimal = tree.best();
        assert_eq!(minimal.stimuli.len(), 1, "{minimal:?}");
    }

    #[test]
    fn pairs_that_need_each_other_stay() {
        // Frames 5 and 6 can only be removed together: they are a request and its follow-up.
        let minimal = shrink(sequence(&[1, 5, 6, 9, 5, 6]), |ids| ids.windows(2).any(|pair| pair == [5, 6]));
        assert_eq!(minimal.stimuli.len(), 2);
        // A dialogue can only be removed with its end.
        let dialogue = [1, 2, 3, 4];
        let is_whole = |ids: &[u32]| {
            let starts = ids.iter().filter(|id| **id == 1).count();
            starts == ids.windows(4).filter(|four| *four == dialogue).count() && ids.ends_with(&[7, 8])
        };
        let minimal = shrink(sequence(&[5, 1, 2, 3, 4, 6, 1, 2, 3, 4, 7, 8]), is_whole);
        assert_eq!(minimal.stimuli.len(), 2);
    }
}
