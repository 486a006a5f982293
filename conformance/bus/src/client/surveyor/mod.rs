//! Reads the object dictionary of a device: every described entry, or every index of a range. It writes nothing.

use super::exchange::Exchange;
use super::sdo::{Outcome, Transfer};
use super::{Excess, UploadLimit};
use crate::BusError;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::dictionary::survey::{Answer, Survey};
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Index, Multiplexer, NodeId, SubIndex};
use canvass_traces::Duration;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// Maximum number of requests for an entry, if the bus is interrupted during each of them.
const MOST_INTERRUPTED: u32 = 8;
/// Number of silent indexes after which a survey gives up a device that does not answer for absent objects.
const MOST_SILENT: u32 = 16;
/// The distance of two samples of a reserved area.
const SAMPLE: usize = 0x40;
/// Maximum length of a gap of reserved sub-indexes in an object.
const MOST_ABSENT: u32 = 16;
/// The highest sub-index that is read: FFh holds the object's structure.
const LAST_SUB: u8 = 0xFE;

/// Why a survey ended early.
#[derive(Debug, thiserror::Error)]
pub enum SurveyError {
    /// The bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// The device never answered.
    #[error("node {0} does not answer: does it exist, and does the bus have its bit rate?")]
    Unanswered(NodeId),
    /// The device answered at first, but no longer.
    #[error("node {node} no longer answers, from {at} on")]
    Gone {
        /// Node-ID of the device.
        node: NodeId,
        /// The first entry without an answer.
        at: Multiplexer,
    },
    /// The observer has ended the survey.
    #[error("the survey was ended before it was complete")]
    Ended,
}

/// Reads a device.
pub struct Surveyor<'a, 'b> {
    exchange: &'a mut Exchange<'b>,
    node: NodeId,
    patience: Duration,
    limit: UploadLimit,
    watch: &'a mut dyn FnMut(Multiplexer) -> bool,
    survey: Survey,
    unread: Option<Multiplexer>,
    excesses: Vec<(Multiplexer, Excess)>,
    /// The objects whose sub-indexes were all read.
    whole: BTreeSet<Index>,
}

impl<'a, 'b> Surveyor<'a, 'b> {
    /// Begins a survey. `patience` is the timeout of each response; `watch` is called before each entry, and ends the
    /// survey by returning `false`.
    pub fn new(
        exchange: &'a mut Exchange<'b>,
        node: NodeId,
        patience: Duration,
        watch: &'a mut dyn FnMut(Multiplexer) -> bool,
    ) -> Self {
        Self {
            exchange,
            node,
            patience,
            limit: UploadLimit::OF_MANY,
            watch,
            survey: Survey::default(),
            unread: None,
            excesses: Vec::new(),
            whole: BTreeSet::new(),
        }
    }

    /// Sets another limit of each upload.
    #[must_use]
    pub fn within(self, limit: UploadLimit) -> Self {
        Self { limit, ..self }
    }

    /// The answers, and the values that exceeded the limit.
    pub fn into_survey(self) -> (Survey, Vec<(Multiplexer, Excess)>) {
        (self.survey, self.excesses)
    }

    /// The entry at which the survey ended, if it was not read.
    pub const fn unread(&self) -> Option<Multiplexer> {
        self.unread
    }

    /// Reads an entry, unless it was read before.
    ///
    /// # Errors
    /// [`SurveyError`] if the bus fails or the device has gone.
    pub fn read(&mut self, at: Multiplexer) -> Result<&Answer, SurveyError> {
        if self.survey.get(at).is_none() {
            self.unread = Some(at);
            if !(self.watch)(at) {
                return Err(SurveyError::Ended);
            }
            let answer = self.ask_again(at)?;
            let is_silent = answer == Answer::Silent;
            self.survey.insert(at, answer);
            if is_silent {
                self.refuse_gone(at)?;
            }
            self.unread = None;
        }
        // The entry was read, by this call or before.
        Ok(self.survey.get(at).unwrap_or(&Answer::Silent))
    }

    /// Requests an entry, and repeats the request if no answer comes: a frame may be lost, or the device busy.
    fn ask_again(&mut self, at: Multiplexer) -> Result<Answer, BusError> {
        let first = self.ask(at)?;
        if first != Answer::Silent {
            return Ok(first);
        }
        for _ in 0..MOST_INTERRUPTED {
            let before = self.exchange.bus.health();
            let answer = self.ask(at)?;
            if answer != Answer::Silent || self.exchange.bus.health().since(&before).interruptions == 0 {
                return Ok(answer);
            }
        }
        Ok(Answer::Silent)
    }

    fn ask(&mut self, at: Multiplexer) -> Result<Answer, BusError> {
        let transfer = Transfer::upload_within(at, self.limit);
        Ok(match self.exchange.transfer(self.node, transfer, self.patience)? {
            Outcome::Uploaded(value) => Answer::Value(value),
            Outcome::Aborted(abort) => Answer::Aborted(abort.code),
            Outcome::Silent => Answer::Silent,
            Outcome::Exceeded(excess) => {
                self.excesses.push((at, excess));
                Answer::Long(excess.least())
            }
            violated @ (Outcome::Violated(_) | Outcome::Downloaded) => Answer::Violated(violated.to_string()),
        })
    }

    /// Checks, after entries without an answer, that the device still answers: reads an entry that every device has.
    fn refuse_gone(&mut self, at: Multiplexer) -> Result<(), SurveyError> {
        const DEVICE_TYPE: Multiplexer = Multiplexer::new(object::DEVICE_TYPE, 0);
        if self.ask_again(DEVICE_TYPE)? != Answer::Silent {
            return Ok(());
        }
        let has_answered = self.survey.answers().any(|(_, answer)| *answer != Answer::Silent);
        let node = self.node;
        Err(if has_answered { SurveyError::Gone { node, at } } else { SurveyError::Unanswered(node) })
    }

    /// Reads every entry of the description, and further sub-indexes of its objects.
    ///
    /// # Errors
    /// [`SurveyError`] if the bus fails or the device has gone.
    pub fn described(&mut self, description: &DeviceDescription) -> Result<(), SurveyError> {
        for object in description.dictionary.objects() {
            for entry in object.entries().iter().filter(|entry| !entry.flags.refuses_read_on_scan()) {
                self.read(Multiplexer { index: object.index, sub: entry.sub })?;
            }
            if object.entries().iter().any(|entry| entry.flags.refuses_read_on_scan()) {
                self.whole.insert(object.index);
                continue;
            }
            let highest = object.entries().last().map_or(0, |entry| entry.sub.0);
            if self.has(object.index) {
                self.subs(object.index, highest.saturating_add(1))?;
            }
        }
        Ok(())
    }

    /// Reads sub-index 0 of every index, and the other sub-indexes of each existing object. Returns the index at which
    /// it gave up, because the device does not answer for absent objects.
    ///
    /// # Errors
    /// [`SurveyError`] if the bus fails or the device has gone.
    pub fn area(&mut self, indexes: RangeInclusive<u16>) -> Result<Option<Index>, SurveyError> {
        let mut silent = 0;
        for index in indexes {
            let at = Multiplexer::new(index, 0);
            let answer = self.read(at)?;
            silent = if *answer == Answer::Silent { silent + 1 } else { 0 };
            if silent >= MOST_SILENT {
                return Ok(Some(Index(index)));
            }
            // An object may have sub-indexes without sub-index 0.
            let may_have_subs = answer.exists() == Some(true) || *answer == Answer::Aborted(AbortCode::NO_SUB_INDEX);
            if may_have_subs && !self.whole.contains(&Index(index)) {
                self.subs(Index(index), 1)?;
            }
        }
        Ok(None)
    }

    /// Reads every 64th index of an area that the standard reserves, and the whole area if one of them exists.
    /// Returns the index at which it gave up, as [`Surveyor::area`] does.
    ///
    /// # Errors
    /// [`SurveyError`] if the bus fails or the device has gone.
    pub fn reserved(&mut self, indexes: RangeInclusive<u16>) -> Result<Option<Index>, SurveyError> {
        let mut silent = 0;
        for index in indexes.clone().step_by(SAMPLE) {
            let answer = self.read(Multiplexer::new(index, 0))?;
            silent = if *answer == Answer::Silent { silent + 1 } else { 0 };
            if silent >= MOST_SILENT {
                return Ok(Some(Index(index)));
            }
            if answer.exists() == Some(true) || *answer == Answer::Aborted(AbortCode::NO_SUB_INDEX) {
                return self.area(indexes);
            }
        }
        Ok(None)
    }

    /// Reads the sub-indexes that sub-index 0 counts, at least up to `least`, and goes on while further ones exist:
    /// sub-index 0 of a mapping counts only the used ones.
    fn subs(&mut self, index: Index, least: u8) -> Result<(), SurveyError> {
        self.whole.insert(index);
        let counted = self.survey.count(index).unwrap_or(0).max(least);
        let mut absent = 0;
        for sub in 1..=LAST_SUB {
            let exists = self.read(Multiplexer { index, sub: SubIndex(sub) })?.exists() == Some(true);
            absent = if exists { 0 } else { absent + 1 };
            // In an object without sub-indexes, sub-index 0 is the value, not a count: a long gap ends the loop even
            // below the count.
            if !exists && (sub >= counted || sub >= least && absent >= MOST_ABSENT) {
                break;
            }
        }
        Ok(())
    }

    /// Whether any entry of the object exists.
    fn has(&self, index: Index) -> bool {
        self.survey.of(index).any(|(_, answer)| answer.exists() == Some(true))
    }
}

#[cfg(test)]
mod tests;
