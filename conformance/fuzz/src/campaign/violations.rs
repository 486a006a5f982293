//! What becomes of a violation that was seen: it is repeated from power-on, made shorter, and told of once.

use super::{Campaign, Found, Standing};
use crate::execute::{Ended, Pace};
use crate::oracle::Violation;
use crate::property::Property;
use crate::shrink::SequenceTree;
use crate::stand::TestStand;
use crate::stimulus::Sequence;
use canvass_bus::BusError;
use canvass_traces::{Duration, Timestamp};
use proptest::strategy::ValueTree;

/// A violation that did not come back so often is not tried again.
const MOST_DOUBTS: u32 = 3;

/// On a device that goes on, shrinking one violation ends after that time of the bus.
const LONGEST_SHRINKING: Duration = Duration::from_secs(5);

impl Campaign<'_> {
    /// A violation was seen: it is repeated from power-on, with its sequence alone or, on a device that goes on, with all
    /// that came before it. What was seen at the swift pace and does not come back may have been a late answer to another
    /// frame: it is told of when it was seen several times.
    pub(super) fn judge(
        &mut self,
        stand: &mut dyn TestStand,
        mut tree: SequenceTree,
        violation: Violation,
        pace: Pace,
    ) -> Result<(), BusError> {
        let key = (violation.property, violation.rule);
        let doubts = match self.seen.get(&key) {
            Some(Standing::Confirmed | Standing::Doubtful(MOST_DOUBTS..)) => {
                // What is silence this time was waited for in full, and is not waited for so long again.
                self.executor.take_for_granted(&violation);
                return Ok(());
            }
            Some(Standing::Doubtful(doubts)) => *doubts,
            None => 0,
        };
        let (sequence, whole) = (tree.current(), self.executor.since_start());
        let seen = Found {
            violation,
            sequence,
            evidence: self.executor.evidence.clone(),
            confirmed: false,
            state: self.executor.kept.clone(),
        };
        let mut confirmed = self.confirm(stand, &seen.sequence, &seen.violation, Pace::Careful)?;
        let is_whole = matches!(confirmed, Confirmed::No) && whole.stimuli.len() > seen.sequence.stimuli.len();
        if is_whole {
            // It is long: whether it shows anything is tried at the pace at which it was seen.
            self.executor.forget_rest();
            confirmed = self.confirm(stand, &whole, &seen.violation, Pace::Swift)?;
            tree = SequenceTree::new(whole);
        }
        let (found, lost) = match confirmed {
            Confirmed::Again if is_whole => (self.shrink_whole(stand, tree, seen)?, None),
            Confirmed::Again => (self.shrink(stand, &mut tree, seen.violation)?, None),
            Confirmed::No => (seen, None),
            Confirmed::Lost(lost, dead) => (seen, Some((lost, dead))),
        };
        if !found.confirmed
            && lost.is_none()
            && doubts + 1 < MOST_DOUBTS
            && pace == Pace::Swift
            && self.may_be_mixed_up(&found.violation)
        {
            self.executor.distrust(key.0);
            self.seen.insert(key, Standing::Doubtful(doubts + 1));
            return Ok(());
        }
        let standing = if found.confirmed { Standing::Confirmed } else { Standing::Doubtful(doubts + 1) };
        self.seen.insert(key, standing);
        if matches!(standing, Standing::Confirmed | Standing::Doubtful(MOST_DOUBTS..)) {
            self.executor.take_for_granted(&found.violation);
        }
        let is_known = |other: &&mut Found| (other.violation.property, other.violation.rule) == key;
        match self.violations.iter_mut().find(is_known) {
            Some(before) if found.confirmed => *before = found,
            Some(_) => {}
            None => self.violations.push(found),
        }
        match lost {
            Some((violation, dead)) => self.lose(stand, violation, dead),
            None => Ok(()),
        }
    }

    /// Whether what was seen at the swift pace may come from an answer to another frame, or from an order of service that
    /// nobody has promised.
    fn may_be_mixed_up(&self, violation: &Violation) -> bool {
        // A device that has died is no matter of order.
        violation.property != Property::Alive
            && !violation.is_silence
            && (self.executor.is_in_order(violation.property) || is_mixable(violation))
    }

    /// The device did not come back from a reset: what was sent since the start before, and the frames, are what is known of
    /// its end. `dead`: nor did further resets bring it back.
    pub(super) fn lose(&mut self, stand: &mut dyn TestStand, violation: Violation, dead: bool) -> Result<(), BusError> {
        self.dead |= dead;
        let (sequence, evidence) = self.executor.before_start();
        let key = (violation.property, violation.rule);
        if self.seen.insert(key, Standing::Confirmed).is_some() {
            return Ok(());
        }
        let mut confirmed = false;
        if !dead {
            self.executor.run(stand, &sequence, Pace::Careful, true)?;
            if let Ended::Lost { dead, .. } = self.executor.restart(stand)? {
                confirmed = true;
                self.dead |= dead;
            }
        }
        self.violations.push(Found { violation, sequence, evidence, confirmed, state: Vec::new() });
        Ok(())
    }

    /// Whether the sequence shows the same violation again: at the careful pace from power-on.
    fn confirm(
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

    /// Makes the sequence shorter. It has shown the violation from power-on. On a device that goes on most tries begin where
    /// the one before has ended, which takes far less time than a reset; what they leave has to show it from power-on. If it
    /// does not, each try begins there.
    fn shrink(
        &mut self,
        stand: &mut dyn TestStand,
        tree: &mut SequenceTree,
        violation: Violation,
    ) -> Result<Found, BusError> {
        let whole = Found {
            sequence: tree.best().clone(),
            evidence: self.executor.evidence.clone(),
            state: self.executor.kept.clone(),
            violation: violation.clone(),
            confirmed: true,
        };
        if !stand.is_repeatable() {
            let found = self.shrink_at(stand, &mut tree.clone(), violation.clone(), Pace::Swift)?.0;
            if found.confirmed || self.dead || self.plan.time.is_over() {
                return Ok(if found.confirmed { found } else { whole });
            }
            self.executor.evidence = whole.evidence.clone();
        }
        let (found, has_hurried) = self.shrink_at(stand, tree, violation, Pace::Careful)?;
        Ok(if has_hurried && !found.confirmed { whole } else { found })
    }

    /// The same of all that was sent since the last start, which has shown the violation at the swift pace only. What that
    /// leaves has to show it at the careful one.
    fn shrink_whole(
        &mut self,
        stand: &mut dyn TestStand,
        mut tree: SequenceTree,
        seen: Found,
    ) -> Result<Found, BusError> {
        let found = self.shrink_at(stand, &mut tree.clone(), seen.violation.clone(), Pace::Swift)?.0;
        if found.confirmed || self.dead || self.plan.time.is_over() {
            return Ok(if found.confirmed { found } else { seen });
        }
        match self.confirm(stand, tree.best(), &seen.violation, Pace::Careful)? {
            Confirmed::Again => {
                let whole = tree.best().clone();
                let evidence = self.executor.evidence.clone();
                let (found, _) = self.shrink_at(stand, &mut tree, seen.violation.clone(), Pace::Careful)?;
                Ok(if found.confirmed { found } else { Found { sequence: whole, evidence, confirmed: true, ..seen } })
            }
            Confirmed::No => Ok(seen),
            Confirmed::Lost(lost, dead) => {
                self.lose(stand, lost, dead)?;
                Ok(seen)
            }
        }
    }

    /// The shortest that was found at that pace, and whether some of it was shown without the whole of its time.
    fn shrink_at(
        &mut self,
        stand: &mut dyn TestStand,
        tree: &mut SequenceTree,
        violation: Violation,
        pace: Pace,
    ) -> Result<(Found, bool), BusError> {
        // For what was found missing nobody waits as long again with each try.
        self.executor.presume(Some((violation.property, violation.rule)));
        let mut shown = Vec::new();
        let shortest = self.shorten(stand, tree, violation, pace, &mut shown);
        let has_hurried = self.executor.presume(None);
        let mut found = self.show(stand, shortest?, pace)?;
        // What a try left out may have been there from the one before: then a longer one shows it from power-on.
        let longer =
            (0..u32::BITS).map_while(|doubled| shown.len().checked_sub(1 << doubled).and_then(|n| shown.get(n)));
        for sequence in longer.filter(|_| pace == Pace::Swift) {
            if found.confirmed || self.dead || self.plan.time.is_over() {
                break;
            }
            found = self.show(stand, Found { sequence: sequence.clone(), confirmed: true, ..found }, pace)?;
        }
        Ok((found, has_hurried))
    }

    fn shorten(
        &mut self,
        stand: &mut dyn TestStand,
        tree: &mut SequenceTree,
        violation: Violation,
        pace: Pace,
        longer: &mut Vec<Sequence>,
    ) -> Result<Found, BusError> {
        // The frames of the shortest sequence so far, where they are kept.
        let mut shown = std::mem::take(&mut self.executor.evidence);
        let until = match stand.is_repeatable() {
            true => Timestamp::MAX,
            false => stand.bus().now() + LONGEST_SHRINKING,
        };
        let mut more = tree.simplify();
        let mut tries = 0;
        while more && tries < self.plan.shrink_budget && stand.bus().now() < until && !self.plan.time.is_over() {
            tries += 1;
            more = match self.confirm(stand, tree.tried(), &violation, pace)? {
                Confirmed::Again => {
                    shown = std::mem::take(&mut self.executor.evidence);
                    longer.push(tree.best().clone());
                    tree.simplify()
                }
                Confirmed::No => tree.complicate(),
                Confirmed::Lost(lost, dead) => {
                    self.lose(stand, lost, dead)?;
                    !self.dead && tree.complicate()
                }
            };
        }
        let (sequence, state) = (tree.best().clone(), self.executor.kept.clone());
        Ok(Found { violation, sequence, evidence: shown, confirmed: true, state })
    }

    /// Once more from power-on with its frames, and with the words for this sequence, if there is time for it. Without that,
    /// what was shortened at the swift pace is not confirmed.
    fn show(&mut self, stand: &mut dyn TestStand, shortest: Found, pace: Pace) -> Result<Found, BusError> {
        if self.plan.time.is_over() && !shortest.evidence.is_empty() {
            return Ok(Found { confirmed: pace == Pace::Careful, ..shortest });
        }
        let last = match self.dead {
            true => Ended::Well,
            false => self.executor.run(stand, &shortest.sequence, Pace::Careful, true)?,
        };
        let evidence = std::mem::take(&mut self.executor.evidence);
        let shown = Found { evidence, state: self.executor.kept.clone(), ..shortest };
        Ok(match last {
            Ended::Violation(last) if is_same(&last, &shown.violation) => Found { violation: last, ..shown },
            Ended::Lost { violation: lost, dead } => {
                self.lose(stand, lost, dead)?;
                Found { confirmed: false, ..shown }
            }
            _ => Found { confirmed: false, ..shown },
        })
    }
}

/// What became of a repetition.
enum Confirmed {
    /// The same violation.
    Again,
    /// Another one, or none.
    No,
    /// The device did not come back from the reset before it, which is a violation of its own; whether further resets
    /// did not bring it back either.
    Lost(Violation, bool),
}

/// Whether the answer to another frame, come late, can look like that.
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

fn is_same(one: &Violation, other: &Violation) -> bool {
    (one.property, one.rule) == (other.property, other.rule)
}
