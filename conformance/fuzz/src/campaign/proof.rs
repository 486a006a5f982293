//! The proof of a violation: it comes back in each of several repetitions, all of which have the same start.
//!
//! On a simulated bus a repetition starts with a new device. A live device is reset, after frames that bring its SDO
//! server into the same state each time. At first the next frame is sent when the device has answered, and then at its
//! time in the log, as a player does that does not wait for answers.

use super::violations::is_same;
use super::{Campaign, Found, Repetition, Replay};
use crate::Knowledge;
use crate::execute::{Ended, Pace};
use crate::prelude::prelude;
use crate::stand::TestStand;
use crate::stimulus::{SETTLE, Sequence, Stimulus, Then};
use canvass_bus::BusError;
use canvass_traces::{Direction, Duration, Record};

/// Number of repetitions that confirm a violation.
pub(super) const REPETITIONS: usize = 3;

/// Part of the pause between two frames of a log that an answer may take.
const SHARE: u64 = 2;

/// The repetitions of a sequence.
struct Proof {
    /// The violation with the sequence that was repeated last.
    found: Found,
    /// Whether a violation came before the sequence began.
    is_early: bool,
}

impl Campaign<'_> {
    /// Sends once the frames with which every repetition begins. They tell whether a live device violates something before
    /// the sequence of a violation.
    pub(super) fn try_prelude(&mut self, stand: &mut dyn TestStand) -> Result<(), BusError> {
        if stand.is_repeatable() || self.plan.time.is_over() {
            return Ok(());
        }
        self.is_prelude_clean = false;
        let stimuli = self.prelude(stand);
        let ended = self.executor.run(stand, &Sequence { stimuli, ..Sequence::default() }, Pace::Careful, false)?;
        self.is_prelude_clean = matches!(ended, Ended::Well);
        Ok(())
    }

    /// The frames before each repetition. A device that violated something in them when the run began gets the full time
    /// for its boot-up message: if this message is missing, that shows before the sequence.
    fn prelude(&self, stand: &dyn TestStand) -> Vec<Stimulus> {
        let Knowledge { node, patience, .. } = *self.executor.knowledge();
        let usual = stand.restart_time().times(2);
        let boot = if self.is_prelude_clean { usual } else { usual.max(patience.boot + SETTLE) };
        prelude(node, boot)
    }

    /// Repeats a violation until it is confirmed, or does not come back.
    pub(super) fn prove(&mut self, stand: &mut dyn TestStand, found: Found) -> Result<Found, BusError> {
        let is_live = !stand.is_repeatable();
        let bare = Found { prelude: Vec::new(), repetitions: Vec::new(), is_live, ..found };
        if is_live {
            let prelude = self.prelude(stand);
            let proof = self.prove_from(stand, Found { prelude, ..bare.clone() })?;
            // A device that violates something in the frames before the sequence, and did not do so when the run began, has
            // been brought there by what came before: nothing is certain about its start.
            if !proof.is_early || self.is_prelude_clean {
                return Ok(proof.found);
            }
        }
        Ok(self.prove_from(stand, bare)?.found)
    }

    /// Repeats a violation with the frames before it.
    fn prove_from(&mut self, stand: &mut dyn TestStand, found: Found) -> Result<Proof, BusError> {
        let mut proof = Proof { found: Found { confirmed: false, ..found }, is_early: false };
        let Some(answered) = self.repeat_once(stand, &mut proof, Replay::Answers)? else { return Ok(proof) };
        let first = proof.found.clone();
        for timed in [paced(&answered, &first), exact(&answered, &first)] {
            let length = timed.len();
            let sequence = Sequence { stimuli: timed, ..first.sequence.clone() };
            proof.found = Found { sequence, ..first.clone() };
            if self.repeat_all(stand, &mut proof, Replay::Times)? {
                if proof.found.sequence.stimuli.len() < length {
                    // The violation comes earlier at these times, which a replay that waits for answers must keep, too.
                    play(&mut proof.found.sequence.stimuli);
                }
                return Ok(proof);
            }
        }
        let repetitions = proof.found.repetitions.clone();
        proof.found = Found { repetitions, ..first };
        self.repeat_all(stand, &mut proof, Replay::Answers)?;
        Ok(proof)
    }

    /// Repeats until the violation has come [`REPETITIONS`] times, or once did not come.
    fn repeat_all(&mut self, stand: &mut dyn TestStand, proof: &mut Proof, replay: Replay) -> Result<bool, BusError> {
        for _ in 1..REPETITIONS {
            if self.repeat_once(stand, proof, replay)?.is_none() {
                return Ok(false);
            }
        }
        proof.found.confirmed = true;
        Ok(true)
    }

    /// Repeats the sequence once. Returns the times from each frame to the next, if the violation came.
    fn repeat_once(
        &mut self,
        stand: &mut dyn TestStand,
        proof: &mut Proof,
        replay: Replay,
    ) -> Result<Option<Vec<Duration>>, BusError> {
        if !stand.is_repeatable() && self.plan.time.is_over() {
            return Ok(None);
        }
        let found = &mut proof.found;
        let mut sequence = found.whole();
        if replay == Replay::Times {
            play(&mut sequence.stimuli);
        }
        let before = found.prelude.len();
        let ended = self.executor.run(stand, &sequence, Pace::Careful, true)?;
        let (sent, added) = self.executor.sent();
        let added = added.to_vec();
        let evidence = self.executor.history.take_evidence();
        let is_early = before > 0 && sent <= before;
        let (shows, came) = match &ended {
            Ended::Well => (false, "no violation".to_owned()),
            Ended::Violation(violation) | Ended::Lost { violation, .. } if !is_same(violation, &found.violation) => {
                let place = if is_early { "before the sequence: " } else { "" };
                (false, format!("{place}{} {}: {}", violation.property, violation.rule, violation.actual))
            }
            Ended::Violation(violation) | Ended::Lost { violation, .. } => (!is_early, violation.actual.to_string()),
        };
        proof.is_early |= is_early && !matches!(ended, Ended::Well);
        let is_cut_short = matches!(ended, Ended::Well) && !stand.is_repeatable() && self.plan.time.is_over();
        if !is_cut_short {
            found.repetitions.push(Repetition { replay, shows, came });
        }
        match ended {
            Ended::Violation(violation) if shows => {
                // The last stimuli are those of the executor, which finds the effects of the sequence with them.
                found.sequence.stimuli.truncate(sent - before);
                found.sequence.stimuli.extend(added);
                found.violation = violation;
                found.state = self.executor.kept().to_vec();
                let gaps = gaps(&evidence);
                found.evidence = since_stimulus(evidence, before);
                Ok(Some(gaps.into_iter().skip(before).collect()))
            }
            Ended::Lost { violation, dead } => {
                self.lose(stand, violation, dead)?;
                Ok(None)
            }
            _ => Ok(None),
        }
    }
}

/// Replaces each wait for an answer, except for the last, by the pause of a log.
fn play(stimuli: &mut [Stimulus]) {
    let Some((_, all)) = stimuli.split_last_mut() else { return };
    all.iter_mut().filter(|stimulus| stimulus.then == Then::Settle).for_each(|stimulus| {
        stimulus.then = Then::Pause(SETTLE);
    });
}

/// The times from each own frame to the next.
fn gaps(evidence: &[Record]) -> Vec<Duration> {
    let sent: Vec<_> = evidence.iter().filter(|record| record.direction == Direction::Tx).collect();
    sent.windows(2).map(|pair| pair[1].timestamp.since(pair[0].timestamp)).collect()
}

/// The frames from the own frame with this number on.
fn since_stimulus(evidence: Vec<Record>, number: usize) -> Vec<Record> {
    let mut own = evidence.iter().enumerate().filter(|(_, record)| record.direction == Direction::Tx);
    let from = if number == 0 { Some(0) } else { own.nth(number).map(|(at, _)| at) };
    evidence.into_iter().skip(from.unwrap_or(0)).collect()
}

/// The stimuli with longer pauses where the device takes longer than the usual pause of a log.
fn paced(gaps: &[Duration], found: &Found) -> Vec<Stimulus> {
    let paced = |(at, stimulus): (usize, &Stimulus)| {
        let gap = gaps.get(at).copied().unwrap_or_default();
        let then = match stimulus.then {
            Then::Settle if gap.times(SHARE) > SETTLE => Then::Pause(rounded(gap.times(SHARE), 1_000_000)),
            then => then,
        };
        Stimulus { then, ..*stimulus }
    };
    found.sequence.stimuli.iter().enumerate().map(paced).collect()
}

/// The stimuli with pauses of the time that the device has taken.
fn exact(gaps: &[Duration], found: &Found) -> Vec<Stimulus> {
    let exact = |(at, stimulus): (usize, &Stimulus)| {
        let gap = gaps.get(at).filter(|_| stimulus.then == Then::Settle);
        Stimulus { then: gap.map_or(stimulus.then, |gap| Then::Pause(rounded(*gap, 1_000))), ..*stimulus }
    };
    found.sequence.stimuli.iter().enumerate().map(exact).collect()
}

/// The time as a multiple of `unit` nanoseconds, rounded up: a log has whole microseconds.
fn rounded(time: Duration, unit: u64) -> Duration {
    Duration(time.nanos().div_ceil(unit) * unit)
}
