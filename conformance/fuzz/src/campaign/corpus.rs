//! The corpus: sequences that reach combinations of state and command that no sequence before them has reached. It is
//! kept between runs, so that the next run begins where this one ends.

use super::{Campaign, Progress};
use crate::execute::Pace;
use crate::shrink::SequenceTree;
use crate::stand::TestStand;
use canvass_bus::BusError;

impl Campaign<'_> {
    /// Runs the corpus of earlier runs, and keeps the sequences that still reach something new. Returns whether the run
    /// is over: then the rest is kept, too.
    pub(super) fn run_corpus(
        &mut self,
        stand: &mut dyn TestStand,
        pace: Pace,
        go_on: &mut dyn FnMut(Progress<'_>) -> bool,
    ) -> Result<bool, BusError> {
        let mut rest = self.plan.corpus.iter();
        while let Some(sequence) = rest.next() {
            let ended = self.attempt_new(stand, &SequenceTree::new(sequence.clone()), pace);
            if ended.is_err() || self.is_over(go_on) {
                self.corpus.extend(rest.cloned());
                return ended.map(|()| true);
            }
        }
        Ok(false)
    }

    /// Runs a sequence, and keeps it if it reaches something new.
    pub(super) fn attempt_new(
        &mut self,
        stand: &mut dyn TestStand,
        tree: &SequenceTree,
        pace: Pace,
    ) -> Result<(), BusError> {
        let before = self.executor.tally.coverage.exercised();
        let sequence = tree.tried().clone();
        let ended = self.attempt(stand, tree, pace);
        if self.executor.tally.coverage.exercised() > before {
            self.corpus.push(sequence);
        }
        ended
    }
}
