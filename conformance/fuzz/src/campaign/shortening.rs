//! Shortening of confirmed violations. On a simulated bus, shortening is done at once. On a live device, it is done a
//! little at a time, so that most of the run remains for new sequences.

use super::violations::{Confirmed, is_same};
use super::{Campaign, Found, Standing};
use crate::execute::{Ended, Pace};
use crate::oracle::Defect;
use crate::shrink::SequenceTree;
use crate::stand::TestStand;
use crate::stimulus::Sequence;
use canvass_bus::BusError;
use canvass_traces::{Duration, Record, Timestamp};
use proptest::strategy::ValueTree;
use std::time;

/// Maximum time on the bus for the tries to shorten one violation at one pace, on a live device.
const LONGEST: Duration = Duration::from_secs(5);

/// Minimum number of tries even on the slowest device.
const LEAST_TRIES: u32 = 24;

/// Time for shortening one violation before the run continues with new sequences.
const TURN: Duration = Duration::from_millis(250);

/// While the run goes on, one part in [`SHARE`] of the time is spent on shortening.
const SHARE: u64 = 4;

/// In the last part in [`LAST_PART`] of a run, the shortest sequences so far are run from power-on.
const LAST_PART: u32 = 20;

/// A confirmed violation whose sequence is being made shorter. On a live device most tries begin in the state that the
/// previous try has left, which takes far less time than a reset. The resulting sequence has to show the violation from
/// power-on. If it does not, all tries are repeated from power-on.
pub(super) struct Shortening {
    /// The violation as it was confirmed or seen.
    whole: Found,
    /// All frames since a start, if the violation came back only after all of them, at the swift pace. The shortened
    /// sequence then has to be confirmed.
    history: Option<Sequence>,
    tree: SequenceTree,
    pace: Pace,
    tries: u32,
    spent: Duration,
    /// The frames on the bus during the shortest sequence so far, if they are kept.
    evidence: Vec<Record>,
    /// The sequences that showed the violation, each shorter than the previous sequence.
    shown: Vec<Sequence>,
}

impl Shortening {
    /// Begins with a violation that was confirmed from power-on.
    pub fn new(whole: Found, is_repeatable: bool) -> Self {
        Self::at(whole, None, if is_repeatable { Pace::Careful } else { Pace::Swift })
    }

    /// Begins with a violation that came back at the swift pace when all frames since a start were sent again.
    pub(crate) fn of_history(history: Sequence, seen: Found) -> Self {
        Self::at(seen, Some(history), Pace::Swift)
    }

    fn at(whole: Found, history: Option<Sequence>, pace: Pace) -> Self {
        Self {
            tree: SequenceTree::new(history.as_ref().unwrap_or(&whole.sequence).clone()),
            history,
            pace,
            tries: 0,
            spent: Duration::ZERO,
            evidence: whole.evidence.clone(),
            shown: Vec::new(),
            whole,
        }
    }

    fn defect(&self) -> Defect {
        self.whole.violation.defect()
    }

    /// The violation with its shortest sequence so far.
    fn best(&self) -> Found {
        Found { sequence: self.tree.best().clone(), evidence: self.evidence.clone(), ..self.whole.clone() }
    }
}

impl Campaign<'_> {
    /// Shortens the violation at once on a simulated bus. On a live device it returns the violation as confirmed, and
    /// shortens it later.
    pub(super) fn shorten_now_or_later(
        &mut self,
        stand: &mut dyn TestStand,
        mut shortening: Shortening,
    ) -> Result<Found, BusError> {
        if !stand.is_repeatable() {
            let whole = shortening.whole.clone();
            self.unshortened.push_back(shortening);
            return Ok(whole);
        }
        self.shorten_at_once(stand, &mut shortening)
    }

    /// Shortens the violation until there is nothing left to try.
    pub(super) fn shorten_at_once(
        &mut self,
        stand: &mut dyn TestStand,
        shortening: &mut Shortening,
    ) -> Result<Found, BusError> {
        loop {
            if let Some(found) = self.shorten(stand, shortening, Timestamp::MAX)? {
                return Ok(found);
            }
        }
    }

    /// Gives one violation a turn, unless shortening has taken more than its share of the time.
    pub(super) fn shorten_in_turn(&mut self, stand: &mut dyn TestStand) -> Result<(), BusError> {
        if self.unshortened.is_empty() {
            return Ok(());
        }
        if self.is_ending(stand) {
            return self.show_shortest(stand);
        }
        let elapsed = stand.bus().now().since(self.begun);
        if self.shortened_for.times(SHARE) > elapsed { Ok(()) } else { self.take_turn(stand) }
    }

    /// Shortens the remaining violations as long as there is time.
    pub(super) fn shorten_rest(&mut self, stand: &mut dyn TestStand) -> Result<(), BusError> {
        while !self.unshortened.is_empty() && !self.dead && !self.is_ending(stand) {
            self.take_turn(stand)?;
        }
        self.show_shortest(stand)
    }

    fn take_turn(&mut self, stand: &mut dyn TestStand) -> Result<(), BusError> {
        let Some(mut shortening) = self.unshortened.pop_front() else { return Ok(()) };
        let (begun, spent) = (stand.bus().now(), self.executor.tally.spent);
        let found = self.shorten(stand, &mut shortening, begun + TURN);
        self.shortened_for = self.shortened_for + stand.bus().now().since(begun);
        self.spent_on_violations += self.executor.tally.spent.since(&spent);
        match found {
            Ok(Some(found)) => self.replace(&shortening, found),
            Ok(None) => self.unshortened.push_back(shortening),
            Err(error) => {
                self.unshortened.push_back(shortening);
                return Err(error);
            }
        }
        Ok(())
    }

    fn is_ending(&self, stand: &mut dyn TestStand) -> bool {
        if self.plan.time.is_over() {
            return true;
        }
        let elapsed = time::Duration::from(stand.bus().now().since(self.begun));
        self.plan.time.left().is_some_and(|left| left * LAST_PART < elapsed)
    }

    /// Runs the shortest sequence of each violation from power-on, at the end of the run.
    fn show_shortest(&mut self, stand: &mut dyn TestStand) -> Result<(), BusError> {
        while let Some(shortening) = self.unshortened.pop_front() {
            let may_show = !shortening.shown.is_empty() && !self.dead && !self.plan.time.is_over();
            let shown = match may_show {
                true => self.show(stand, shortening.best()),
                false => Ok(shortening.whole.clone()),
            };
            let found = match &shown {
                Ok(shown) if shown.confirmed => shown.clone(),
                _ => shortening.whole.clone(),
            };
            self.replace(&shortening, found);
            shown?;
        }
        Ok(())
    }

    /// Keeps each violation as it was confirmed or seen, because the bus has failed.
    pub(super) fn keep_unshortened(&mut self) {
        while let Some(shortening) = self.unshortened.pop_front() {
            let whole = Found { is_cut_off: !shortening.whole.confirmed, ..shortening.whole.clone() };
            self.replace(&shortening, whole);
        }
    }

    /// Replaces the reported violation by its shortest sequence.
    fn replace(&mut self, shortening: &Shortening, found: Found) {
        let key = shortening.defect();
        if shortening.history.is_some() {
            let doubts = match self.seen.get(&key) {
                Some(Standing::InHistory(doubts)) => *doubts,
                _ => 0,
            };
            return self.tell(found, doubts, true);
        }
        let is_it = |other: &&mut Found| other.violation.defect() == key;
        if let Some(whole) = self.violations.iter_mut().find(is_it) {
            *whole = found;
        }
    }

    /// Shortens the violation until the time `until`. Returns the result once there is one.
    fn shorten(
        &mut self,
        stand: &mut dyn TestStand,
        shortening: &mut Shortening,
        until: Timestamp,
    ) -> Result<Option<Found>, BusError> {
        if !self.try_shorter(stand, shortening, until)? {
            return Ok(None);
        }
        let found = self.show_best(stand, shortening)?;
        let whole = shortening.whole.clone();
        Ok(match shortening.pace {
            _ if found.confirmed => Some(found),
            Pace::Swift if self.dead || self.plan.time.is_over() => Some(whole),
            Pace::Swift => {
                *shortening = Shortening::at(whole, shortening.history.take(), Pace::Careful);
                self.confirm_history(stand, shortening)?
            }
            Pace::Careful => Some(whole),
        })
    }

    /// Repeats a history at the careful pace. If the history does not show the violation at this pace, the result is
    /// the violation as seen.
    fn confirm_history(
        &mut self,
        stand: &mut dyn TestStand,
        shortening: &mut Shortening,
    ) -> Result<Option<Found>, BusError> {
        let Some(history) = &shortening.history else { return Ok(None) };
        match self.confirm(stand, history, &shortening.whole.violation, Pace::Careful)? {
            Confirmed::Again => {
                let evidence = self.executor.history.take_evidence();
                let whole = Found { sequence: history.clone(), evidence, ..shortening.whole.clone() };
                let proved = self.prove(stand, whole)?;
                let is_confirmed = proved.confirmed;
                shortening.whole =
                    if is_confirmed { proved } else { needs_earlier(&shortening.whole, history, proved) };
                Ok((!is_confirmed).then(|| shortening.whole.clone()))
            }
            Confirmed::No => {
                let seen = shortening.whole.clone();
                Ok(Some(needs_earlier(&shortening.whole, history, seen)))
            }
            Confirmed::Lost(lost, dead) => {
                self.lose(stand, lost, dead)?;
                Ok(Some(shortening.whole.clone()))
            }
        }
    }

    /// Tries shorter sequences until the time `until`. Returns whether there is nothing left to try.
    fn try_shorter(
        &mut self,
        stand: &mut dyn TestStand,
        shortening: &mut Shortening,
        until: Timestamp,
    ) -> Result<bool, BusError> {
        let Shortening { whole, tree, pace, tries, spent, evidence, shown, .. } = shortening;
        let is_repeatable = stand.is_repeatable();
        // The full time for a missing answer has passed once before; the tries need not wait for it again.
        self.executor.known.presume(Some(whole.violation.defect()));
        let mut more = tree.go_on();
        let over = loop {
            let begun = stand.bus().now();
            let is_long = !is_repeatable && *spent >= LONGEST && *tries >= LEAST_TRIES;
            let is_enough = *tries >= self.plan.shrink_budget || is_long;
            if !more || is_enough || self.plan.time.is_over() {
                break true;
            }
            if !is_repeatable && begun >= until {
                break false;
            }
            *tries += 1;

            more = match self.confirm(stand, tree.tried(), &whole.violation, *pace)? {
                Confirmed::Again => {
                    *evidence = self.executor.history.take_evidence();
                    shown.push(tree.tried().clone());
                    tree.simplify()
                }
                Confirmed::No => tree.complicate(),
                Confirmed::Lost(lost, dead) => {
                    self.lose(stand, lost, dead)?;
                    !self.dead && tree.complicate()
                }
            };
            if !is_repeatable {
                *spent = *spent + stand.bus().now().since(begun);
            }
        };
        self.executor.known.presume(None);
        Ok(over)
    }

    /// Runs the shortest sequence from power-on. A try may have depended on the state that the previous try had left:
    /// if so, longer sequences are run until one shows the violation.
    fn show_best(&mut self, stand: &mut dyn TestStand, shortening: &Shortening) -> Result<Found, BusError> {
        let pace = shortening.pace;
        let mut found = self.show(stand, shortening.best())?;
        let shown = &shortening.shown;
        let longer =
            (1..u32::BITS).map_while(|doubled| shown.len().checked_sub(1 << doubled).and_then(|n| shown.get(n)));
        for sequence in longer.filter(|_| pace == Pace::Swift) {
            if found.confirmed || self.dead || self.plan.time.is_over() {
                break;
            }
            found = self.show(stand, Found { sequence: sequence.clone(), confirmed: true, ..found })?;
        }
        Ok(found)
    }

    /// Runs the sequence from its start and keeps the frames and the violation's texts. If the violation comes, it is
    /// repeated until it is confirmed. If there is no time for it, it stays unconfirmed.
    fn show(&mut self, stand: &mut dyn TestStand, shortest: Found) -> Result<Found, BusError> {
        if self.plan.time.is_over() && !shortest.evidence.is_empty() {
            return Ok(Found { confirmed: false, ..shortest });
        }
        let last = match self.dead {
            true => Ended::Well,
            false => self.executor.run(stand, &shortest.sequence, Pace::Careful, true)?,
        };
        let evidence = self.executor.history.take_evidence();
        let shown = Found { evidence, state: self.executor.kept().to_vec(), ..shortest };
        Ok(match last {
            Ended::Violation(last) if is_same(&last, &shown.violation) => {
                self.prove(stand, Found { violation: last, ..shown })?
            }
            Ended::Lost { violation: lost, dead } => {
                self.lose(stand, lost, dead)?;
                Found { confirmed: false, ..shown }
            }
            _ => Found { confirmed: false, ..shown },
        })
    }
}

/// The violation that came back only when the whole history was sent again at the swift pace. `repeated`: the last
/// attempt to repeat it.
fn needs_earlier(seen: &Found, history: &Sequence, repeated: Found) -> Found {
    let repetitions = repeated.repetitions;
    Found { sequence: history.clone(), repetitions, needs_earlier: true, confirmed: false, ..seen.clone() }
}
