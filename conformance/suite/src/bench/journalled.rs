//! What the bench writes into the journal of the run, each before it happens.

use super::baseline::{Baseline, MemoryLeft};
use super::rewrite::Original;
use super::watch::is_store;
use super::{Bench, Rescue};
use crate::comparison::Comparison;
use crate::journal::{Head, Interrupted, Journal};
use crate::touch::Touch;
use crate::verdict::{Reason, Stop};
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use canvass_traces::Frame;
use std::io;

/// Nothing is changed that was not written down.
fn unwritable(error: &io::Error) -> Stop {
    Stop::Error(Reason::new("what is changed is written into the journal first", "a journal", error.to_string()))
}

impl Bench<'_> {
    /// Begins the journal, if one is wanted: no case has run yet.
    pub(crate) fn begin_journal(
        &mut self,
        bus: &str,
        operational: bool,
        dictionary: &[(Multiplexer, Vec<u8>)],
    ) -> io::Result<()> {
        let Some(path) = &self.options.journal else { return Ok(()) };
        let zero_point = self.baseline.zero_point.as_ref();
        let head = Head { bus, node: self.node(), device: &self.target.model, operational, dictionary, zero_point };
        self.journal = Some(Journal::create(path, &head)?);
        Ok(())
    }

    /// The run is over. Where the device is as it was, the journal is not needed any more; else a sentence says what it is
    /// good for.
    pub(crate) fn end_journal(&mut self, is_put_back: bool) -> Option<String> {
        let journal = self.journal.take()?;
        let path = journal.path().display().to_string();
        if !is_put_back {
            return Some(format!("{path} lists what could not be restored"));
        }
        journal.remove().err().map(|error| format!("{path} is not needed any more and could not be removed: {error}"))
    }

    /// What a start brings was learned.
    pub(super) fn journal_memory(&mut self, stored: &[Original]) -> Result<(), Stop> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        let stored = stored.iter().map(|original| (original.multiplexer, &*original.value));
        journal.memory(stored, self.baseline.stored_zero_point.as_ref()).map_err(|error| unwritable(&error))
    }

    /// A case begins, which may leave more behind than values.
    pub(crate) fn journal_case(&mut self, id: &str, touches: &[Touch]) -> Result<(), Stop> {
        let leaves = |touch: &Touch| *touch != Touch::OtherNodes;
        match &mut self.journal {
            Some(journal) if touches.iter().any(leaves) => journal.begin(id).map_err(|error| unwritable(&error)),
            _ => Ok(()),
        }
    }

    /// The case has put back what it changed, or what it could not put back is reported.
    pub(crate) fn settle_journal(&mut self) {
        // A journal that can't be written ends the next case that changes something.
        let _ = self.journal.as_mut().map_or(Ok(()), Journal::settle);
    }

    /// A value that is about to be written, as it was before.
    pub(super) fn journal_value(&mut self, multiplexer: Multiplexer, value: &[u8]) -> Result<(), Stop> {
        let Some(journal) = &mut self.journal else { return Ok(()) };
        journal.value(multiplexer, value).map_err(|error| unwritable(&error))
    }

    /// A frame is about to be sent.
    pub(super) fn journal_frame(&mut self, frame: &Frame) -> Result<(), Stop> {
        let (Some(journal), Some(cob_id)) = (&mut self.journal, frame.cob_id()) else { return Ok(()) };
        if !is_store(cob_id, frame.data(), self.target.node) {
            return Ok(());
        }
        journal.store().map_err(|error| unwritable(&error))
    }

    /// Puts back what an interrupted run has left behind, where the case that was under way left more than values by its
    /// `rescue`, and compares. `None`: the device does not answer.
    ///
    /// A zero point is not put back: nobody knows whether the device is at rest, and by how much it was moved is told.
    pub(crate) fn put_back(&mut self, run: &Interrupted, rescue: Option<Rescue>) -> Option<Comparison> {
        self.baseline = Baseline::of(run);
        self.baseline.unseen = run.memory.iter().map(|(at, _)| *at).filter(|at| self.is_unseen(*at)).collect();
        self.restoring = true;
        if let Some(rescue) = rescue {
            // What fails here shows in whether the device answers then.
            let _ = rescue(self, run.stored);
        }
        // An SDO transfer may be under way, or the device stopped: its reset ends both.
        if !matches!(self.answers(), Ok(true)) && self.reset(Command::RESET_NODE).is_err() {
            return None;
        }
        // What fails here shows in what is compared then.
        let memory = self.put_back_memory_of(run).unwrap_or_default();
        let configured = run.values.iter().filter(|(multiplexer, _)| self.is_put_back(*multiplexer));
        let originals: Vec<Original> = configured.chain(&run.more).map(Original::from).collect();
        self.write_back(&originals);
        self.leave(run.operational);
        self.restoring = true;
        let more: Vec<Original> = run.more.iter().map(Original::from).collect();
        // What is not in the dictionary is compared with it.
        self.unrestored = self.write_back(&more);
        self.restoring = false;
        let comparison = self.put_back_dictionary(&run.bus, &run.values);
        Some(self.with_memory(comparison, &run.bus, &run.values, memory))
    }

    /// What the interrupted case stored is put back by storing what a start brought before; where the journal does not hold
    /// that, the values that were in use.
    fn put_back_memory_of(&mut self, run: &Interrupted) -> Result<MemoryLeft, Stop> {
        if run.memory.is_empty() && !run.stored {
            return Ok(MemoryLeft::default());
        }
        if run.memory.is_empty() {
            self.baseline.stored =
                Some(run.values.iter().filter(|(at, _)| self.is_put_back(*at)).map(Original::from).collect());
        }
        self.put_back_memory(run.stored, false)
    }
}
