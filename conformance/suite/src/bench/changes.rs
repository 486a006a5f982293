//! The changes that cases made in the device, the values before, and the journal that records them.

use super::baseline::Baseline;
use super::watch::memory_command;
use crate::journal::{Head, Journal};
use crate::touch::Touch;
use crate::verdict::{Reason, Stop};
use canvass_analyzer::dictionary::configuration::Download;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::observation::Subject;
use canvass_traces::Frame;
use std::io;
use std::path::Path;

/// The changes of a run. If there is a journal, every change is written into it before it is made.
#[derive(Default)]
pub(crate) struct Changes {
    journal: Option<Journal>,
    /// The values before the changes of the current case.
    originals: Vec<Download>,
    /// The original values of objects that the bench could not put back after earlier cases.
    unrestored: Vec<Download>,
    /// The device before the run.
    pub(super) baseline: Baseline,
    /// Whether the tester is putting a zero point back. Only then, and in cases that may move a zero point, the tester
    /// writes an object that moves a zero point.
    pub(super) moving_zero_point: bool,
    /// Whether the case wrote an object that is stored as soon as it is written.
    pub(super) wrote_memory: bool,
}

impl Changes {
    /// The values before the changes of the current case.
    pub(super) fn originals(&self) -> &[Download] {
        &self.originals
    }

    /// Whether the value of an object before the case is known.
    pub(super) fn knows(&self, at: Multiplexer) -> bool {
        self.originals().iter().any(|original| original.at == at)
    }

    /// The value that an object had before the case changed it; `None` if it could not be read.
    pub(super) fn value_before(&self, at: Multiplexer) -> Option<&[u8]> {
        let change = self.originals().iter().find(|change| change.at == at)?;
        Some(&change.value)
    }

    /// Keeps the value of an object before the case writes it.
    pub(super) fn keep(&mut self, original: Download) -> Result<(), Stop> {
        let value = |journal: &mut Journal| journal.value(original.at, &original.value);
        written(self.journal.as_mut().map_or(Ok(()), value))?;
        self.originals.push(original);
        Ok(())
    }

    /// Takes the values to put back now. If an earlier case left an object changed, its value is the one before that
    /// case.
    pub(super) fn take(&mut self) -> Vec<Download> {
        let mut originals = std::mem::take(&mut self.unrestored);
        for change in std::mem::take(&mut self.originals) {
            if !originals.iter().any(|known| known.at == change.at) {
                originals.push(change);
            }
        }
        originals
    }

    /// Keeps the values that could not be put back: the bench tries again after the next case, and reports them at the
    /// end of the run.
    pub(super) fn leave(&mut self, unrestored: Vec<Download>) {
        self.unrestored = unrestored;
    }

    /// The values that could not be put back.
    pub(super) fn unrestored(&self) -> &[Download] {
        &self.unrestored
    }

    /// Whether an earlier case left an object with a value that is not the device's own.
    pub(crate) fn is_left_behind(&self, subject: Subject) -> bool {
        self.unrestored.iter().any(|original| subject.covers(original.at.into()))
    }

    /// Begins the journal: no case has run yet.
    pub(super) fn begin_journal(&mut self, path: &Path, head: &Head<'_>) -> io::Result<()> {
        self.journal = Some(Journal::create(path, head)?);
        Ok(())
    }

    /// Ends the journal after the run. If the device is as it was, the file is removed; otherwise the returned sentence
    /// says how to use it.
    pub(crate) fn end_journal(&mut self, is_put_back: bool) -> Option<String> {
        let journal = self.journal.take()?;
        let path = journal.path().display().to_string();
        if !is_put_back {
            return Some(format!("{path} lists what could not be restored"));
        }
        journal.remove().err().map(|error| format!("{path} is no longer needed, but could not be removed: {error}"))
    }

    /// Records the values that a start loads.
    pub(super) fn learn_memory(&mut self, stored: Vec<Download>) -> Result<(), Stop> {
        if let Some(journal) = &mut self.journal {
            let stored = stored.iter().map(|original| (original.at, &*original.value));
            written(journal.memory(stored, self.baseline.stored_zero_point.as_ref()))?;
        }
        self.baseline.stored = Some(stored);
        Ok(())
    }

    /// Begins a case in the journal if the case may leave more behind than values.
    pub(crate) fn begin_case(&mut self, id: &str, touches: &[Touch]) -> Result<(), Stop> {
        let leaves = |touch: &Touch| *touch != Touch::OtherNodes;
        match &mut self.journal {
            Some(journal) if touches.iter().any(leaves) => written(journal.begin(id)),
            _ => Ok(()),
        }
    }

    /// Ends a case in the journal: it has put back its changes, or the values that it could not put back are reported.
    pub(crate) fn settle_journal(&mut self) {
        // If the journal can't be written, the next case that changes something ends with that error.
        let _ = self.journal.as_mut().map_or(Ok(()), Journal::settle);
    }

    /// Records that the device is about to store a written value at once: no command to store shows that.
    pub(super) fn note_memory_written(&mut self) -> Result<(), Stop> {
        self.wrote_memory = true;
        self.journal.as_mut().map_or(Ok(()), |journal| written(journal.store()))
    }

    /// Records a frame that is about to be sent to this node.
    pub(super) fn journal_frame(&mut self, frame: &Frame, node: NodeId) -> Result<(), Stop> {
        let (Some(journal), Some(cob_id)) = (&mut self.journal, frame.cob_id()) else { return Ok(()) };
        if memory_command(cob_id, frame.data(), node).is_none() {
            return Ok(());
        }
        written(journal.store())
    }
}

/// Fails if the journal could not be written: the change must not be made then.
fn written(result: io::Result<()>) -> Result<(), Stop> {
    result.map_err(|error| {
        Stop::Error(Reason::new(
            "each change is written to the journal before it is made",
            "a journal",
            error.to_string(),
        ))
    })
}
