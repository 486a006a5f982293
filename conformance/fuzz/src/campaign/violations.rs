//! Handling of violations: each is repeated from power-on and reported once.

use super::proof::REPETITIONS;
use super::shortening::Shortening;
use super::{Campaign, Found, Repetition, Replay, Standing};
use crate::condense::condense;
use crate::execute::{Ended, Pace};
use crate::oracle::{Symptom, Violation};
use crate::property::Property;
use crate::shrink::SequenceTree;
use crate::stand::TestStand;
use crate::stimulus::Sequence;
use canvass_bus::BusError;
use proptest::strategy::ValueTree;

/// Number of failed repetitions after which a violation is not tried again.
const MOST_DOUBTS: u32 = 3;

/// A violation that is being repeated.
pub(super) struct Unrepeated {
    pub seen: Found,
    /// Number of earlier occurrences of the violation that did not come back.
    pub doubts: u32,
    /// Whether the violation was seen at the swift pace.
    pub is_swift: bool,
}

impl Campaign<'_> {
    /// Repeats a violation from power-on: first with its sequence alone; then, on a live device, with the frames before
    /// it that set the state; then with all frames since the start. A violation seen at the swift pace that does not
    /// come back may have been a late answer to another frame. Such a violation is reported only after several
    /// occurrences.
    pub(super) fn judge(
        &mut self,
        stand: &mut dyn TestStand,
        mut tree: SequenceTree,
        violation: Violation,
        pace: Pace,
    ) -> Result<(), BusError> {
        let key = violation.defect();
        let doubts = match self.seen.get(&key) {
            Some(Standing::Confirmed | Standing::Doubtful(MOST_DOUBTS..)) => {
                // If the violation is a missing answer, its full time has passed now. The fuzzer need not wait for it
                // again.
                self.executor.known.take_for_granted(&violation);
                return Ok(());
            }
            Some(Standing::InHistory(_)) => return Ok(()),
            Some(Standing::Doubtful(doubts)) => *doubts,
            None => 0,
        };
        if self.executor.history.tail() > 0 && !self.executor.is_between() {
            // The earlier frames belong to another violation, after which the device was brought to rest.
            let mut tail = tree.current();
            tail.stimuli.drain(..self.executor.history.tail().min(tail.stimuli.len()));
            tree = SequenceTree::new(tail);
        }
        let whole = self.executor.history.since_start();
        let late = match violation.symptom {
            Symptom::Missing(Some(can_id)) if !stand.is_repeatable() => self.executor.late_answer(stand, can_id)?,
            _ => None,
        };
        let evidence = self.executor.history.evidence().to_vec();
        let state = self.executor.kept().to_vec();
        let seen = Found { state, late, ..Found::seen(violation, tree.current(), evidence) };
        self.unrepeated = Some(Unrepeated { seen: seen.clone(), doubts, is_swift: pace == Pace::Swift });
        let (confirmed, tree, is_whole) = self.repeat(stand, tree, &seen, whole)?;
        let (found, lost) = match confirmed {
            Confirmed::Again if is_whole && self.plan.stop_at_first => {
                let mut shortening = Shortening::of_history(tree.best().clone(), seen);
                (self.shorten_at_once(stand, &mut shortening)?, None)
            }
            Confirmed::Again if is_whole => {
                self.unshortened.push_back(Shortening::of_history(tree.best().clone(), seen));
                self.seen.insert(key, Standing::InHistory(doubts));
                self.unrepeated = None;
                return Ok(());
            }
            Confirmed::Again => {
                let evidence = self.executor.history.take_evidence();
                let state = self.executor.kept().to_vec();
                let whole = Found { state, ..Found::seen(seen.violation.clone(), tree.best().clone(), evidence) };
                let proved = self.prove(stand, whole)?;
                match proved.confirmed {
                    true => {
                        let shortening = Shortening::new(proved, stand.is_repeatable());
                        (self.shorten_now_or_later(stand, shortening)?, None)
                    }
                    false => (Found { repetitions: proved.repetitions, ..seen }, None),
                }
            }
            Confirmed::No if !stand.is_repeatable() && self.plan.time.is_over() => (seen, None),
            Confirmed::No => {
                let came = "no violation of this kind".to_owned();
                let repetitions = vec![Repetition { replay: Replay::Answers, shows: false, came }];
                (Found { repetitions, ..seen }, None)
            }
            Confirmed::Lost(lost, dead) => (seen, Some((lost, dead))),
        };
        let is_swift = lost.is_none() && pace == Pace::Swift;
        self.unrepeated = None;
        self.tell(found, doubts, is_swift);
        match lost {
            Some((violation, dead)) => self.lose(stand, violation, dead),
            None => Ok(()),
        }
    }

    /// Repeats a violation that was seen in `whole`, all frames since the start. Returns the result, the sequence that
    /// was tried last, and whether this sequence is `whole`.
    fn repeat(
        &mut self,
        stand: &mut dyn TestStand,
        mut tree: SequenceTree,
        seen: &Found,
        whole: Sequence,
    ) -> Result<(Confirmed, SequenceTree, bool), BusError> {
        let before = condense(self.executor.history.before_sequence(), self.executor.knowledge());
        let mut confirmed = self.confirm(stand, &seen.sequence, &seen.violation, Pace::Careful)?;
        if matches!(confirmed, Confirmed::No) && !before.is_empty() {
            let mut led = seen.sequence.clone();
            led.stimuli.splice(0..0, before);
            confirmed = self.confirm(stand, &led, &seen.violation, Pace::Careful)?;
            if matches!(confirmed, Confirmed::Again) {
                tree = SequenceTree::new(led);
            }
        }
        let is_whole = matches!(confirmed, Confirmed::No) && whole.stimuli.len() > seen.sequence.stimuli.len();
        if is_whole {
            // This sequence is long: it is tried at the pace at which the violation was seen.
            self.executor.forget_rest();
            confirmed = self.confirm(stand, &whole, &seen.violation, Pace::Swift)?;
            tree = SequenceTree::new(whole);
        }
        Ok((confirmed, tree, is_whole))
    }

    /// Reports a violation. At the swift pace a late answer to another frame can look like a violation: if a repetition
    /// does not show it again, it is reported at its third occurrence (`MOST_DOUBTS`), and before that only counted.
    pub(super) fn tell(&mut self, found: Found, doubts: u32, is_swift: bool) {
        let key = found.violation.defect();
        if !found.confirmed && is_swift && doubts + 1 < MOST_DOUBTS && self.may_be_mixed_up(&found.violation) {
            self.executor.distrust(key.property);
            self.seen.insert(key, Standing::Doubtful(doubts + 1));
            return;
        }
        let standing = if found.confirmed { Standing::Confirmed } else { Standing::Doubtful(doubts + 1) };
        self.seen.insert(key, standing);
        if matches!(standing, Standing::Confirmed | Standing::Doubtful(MOST_DOUBTS..)) {
            self.executor.known.take_for_granted(&found.violation);
        }
        let is_known = |other: &&mut Found| other.violation.defect() == key;
        match self.violations.iter_mut().find(is_known) {
            Some(before) if found.confirmed => *before = found,
            Some(_) => {}
            None => self.violations.push(found),
        }
    }

    /// Whether a violation seen at the swift pace may come from an answer to another frame, or from a device that does
    /// not serve frames in their order.
    fn may_be_mixed_up(&self, violation: &Violation) -> bool {
        // The order of frames does not explain a device that has died.
        violation.property != Property::Alive
            && !violation.is_silence
            && (self.executor.is_in_order(violation.property) || is_mixable(violation))
    }

    /// Reports that the device did not come back from a reset, with the frames sent since the previous start. `dead`:
    /// further resets did not bring it back either.
    pub(super) fn lose(&mut self, stand: &mut dyn TestStand, violation: Violation, dead: bool) -> Result<(), BusError> {
        self.dead |= dead;
        let (sequence, evidence) = self.executor.history.take_before();
        if self.seen.insert(violation.defect(), Standing::Confirmed).is_some() {
            return Ok(());
        }
        let mut found = Found::seen(violation, sequence, evidence);
        let again = if dead { Ok(()) } else { self.lose_again(stand, &mut found) };
        found.confirmed = !found.repetitions.is_empty() && found.repetitions.iter().all(|repetition| repetition.shows);
        found.is_cut_off = again.is_err();
        self.violations.push(found);
        again
    }

    /// Repeats the sequence and resets the device, until it once comes back or is dead.
    fn lose_again(&mut self, stand: &mut dyn TestStand, found: &mut Found) -> Result<(), BusError> {
        for _ in 0..REPETITIONS {
            self.executor.run(stand, &found.sequence, Pace::Careful, true)?;
            let ended = self.executor.restart(stand)?;
            let (shows, came) = match &ended {
                Ended::Lost { violation, .. } => (true, violation.actual.to_string()),
                Ended::Well | Ended::Violation(_) => (false, "the device came back".to_owned()),
            };
            found.repetitions.push(Repetition { replay: Replay::Answers, shows, came });
            match ended {
                Ended::Lost { dead: false, .. } => {}
                Ended::Lost { dead: true, .. } => {
                    self.dead = true;
                    break;
                }
                Ended::Well | Ended::Violation(_) => break,
            }
        }
        Ok(())
    }

    /// Whether the sequence shows the same violation again. At the careful pace it begins from power-on.
    pub(super) fn confirm(
        &mut self,
        stand: &mut dyn TestStand,
        sequence: &Sequence,
        as_in: &Violation,
        pace: Pace,
    ) -> Result<Confirmed, BusError> {
        let keep = !stand.is_repeatable();
        Ok(match self.executor.run(stand, sequence, pace, keep)? {
            Ended::Violation(violation) if is_same(&violation, as_in) => Confirmed::Again,
            Ended::Lost { violation, dead } if keep => Confirmed::Lost(violation, dead),
            _ => Confirmed::No,
        })
    }
}

/// The result of a repetition.
pub(super) enum Confirmed {
    /// The same violation came again.
    Again,
    /// Another violation came, or none.
    No,
    /// The device did not come back from the reset before the repetition, which is a violation of its own. The flag
    /// says whether further resets did not bring it back either.
    Lost(Violation, bool),
}

/// Whether a late answer to another frame can look like the violation.
fn is_mixable(violation: &Violation) -> bool {
    let is_answer = matches!(
        violation.property,
        Property::LegalSdo
            | Property::OneAnswer
            | Property::Silent
            | Property::Consistent
            | Property::ReadBack
            | Property::AbortedUnchanged
            | Property::Restored
            | Property::LegalLss
            | Property::Fastscan
    );
    is_answer && !violation.is_silence
}

pub(super) fn is_same(one: &Violation, other: &Violation) -> bool {
    one.defect() == other.defect()
}
