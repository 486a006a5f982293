//! What was changed in the device, what it was before, and the journal that tells of it.

use super::baseline::Baseline;
use super::rewrite::Original;
use super::watch::is_store;
use crate::journal::{Head, Journal};
use crate::touch::Touch;
use crate::verdict::{Reason, Stop};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::observation::Subject;
use canvass_traces::Frame;
use std::io;
use std::path::Path;

/// The changes of a run. Nothing is changed that was not written into the journal before, where there is one.
#[derive(Default)]
pub(crate) struct Changes {
    journal: Option<Journal>,
    /// What the case has changed, with the values before.
    originals: Vec<Original>,
    /// What earlier cases have changed and could not put back.
    unrestored: Vec<Original>,
    /// What the device was before the run.
    pub(super) baseline: Baseline,
    /// A zero point is being put back: the only write to what moves it outside of a case that may move it.
    pub(super) moving_zero_point: bool,
    /// The case wrote an object that is stored as soon as it is written.
    pub(super) wrote_memory: bool,
}

impl Changes {
    /// What the case has changed, with the values before.
    pub(super) fn originals(&self) -> &[Original] {
        &self.originals
    }

    /// Whether the value before is known of an object that the case has changed.
    pub(super) fn knows(&self, at: Multiplexer) -> bool {
        self.originals().iter().any(|original| original.multiplexer == at)
    }

    /// The value that an object had before the case changed it, where it could be read.
    pub(super) fn value_before(&self, at: Multiplexer) -> Option<&[u8]> {
        let change = self.originals().iter().find(|change| change.multiplexer == at)?;
        Some(&change.value)
    }

    /// Keeps the value of an object that is about to be written.
    pub(super) fn keep(&mut self, original: Original) -> Result<(), Stop> {
        let value = |journal: &mut Journal| journal.value(original.multiplexer, &original.value);
        written(self.journal.as_mut().map_or(Ok(()), value))?;
        self.originals.push(original);
        Ok(())
    }

    /// What is to be put back now: of an object that an earlier case has left behind, the value before that case.
    pub(super) fn take(&mut self) -> Vec<Original> {
        let mut originals = std::mem::take(&mut self.unrestored);
        for change in std::mem::take(&mut self.originals) {
            if !originals.iter().any(|known| known.multiplexer == change.multiplexer) {
                originals.push(change);
            }
        }
        originals
    }

    /// Keeps what could not be put back: it is tried anew after the next case, and told at the end of the run.
    pub(super) fn leave(&mut self, unrestored: Vec<Original>) {
        self.unrestored = unrestored;
    }

    /// What could not be put back.
    pub(super) fn unrestored(&self) -> &[Original] {
        &self.unrestored
    }

    /// Whether an earlier case has left an object behind with a value that is not the device's own.
    pub(crate) fn is_left_behind(&self, subject: Subject) -> bool {
        self.unrestored.iter().any(|original| subject.covers(original.multiplexer.into()))
    }

    /// Begins the journal: no case has run yet.
    pub(super) fn begin_journal(&mut self, path: &Path, head: &Head<'_>) -> io::Result<()> {
        self.journal = Some(Journal::create(path, head)?);
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
    pub(super) fn learn_memory(&mut self, stored: Vec<Original>) -> Result<(), Stop> {
        if let Some(journal) = &mut self.journal {
            let stored = stored.iter().map(|original| (original.multiplexer, &*original.value));
            written(journal.memory(stored, self.baseline.stored_zero_point.as_ref()))?;
        }
        self.baseline.stored = Some(stored);
        Ok(())
    }

    /// A case begins, which may leave more behind than values.
    pub(crate) fn begin_case(&mut self, id: &str, touches: &[Touch]) -> Result<(), Stop> {
        let leaves = |touch: &Touch| *touch != Touch::OtherNodes;
        match &mut self.journal {
            Some(journal) if touches.iter().any(leaves) => written(journal.begin(id)),
            _ => Ok(()),
        }
    }

    /// The case has put back what it changed, or what it could not put back is reported.
    pub(crate) fn settle_journal(&mut self) {
        // A journal that can't be written ends the next case that changes something.
        let _ = self.journal.as_mut().map_or(Ok(()), Journal::settle);
    }

    /// A frame is about to be sent to that node.
    pub(super) fn journal_frame(&mut self, frame: &Frame, node: NodeId) -> Result<(), Stop> {
        let (Some(journal), Some(cob_id)) = (&mut self.journal, frame.cob_id()) else { return Ok(()) };
        if !is_store(cob_id, frame.data(), node) {
            return Ok(());
        }
        written(journal.store())
    }
}

/// Nothing is changed that was not written down.
fn written(result: io::Result<()>) -> Result<(), Stop> {
    result.map_err(|error| {
        Stop::Error(Reason::new("what is changed is written into the journal first", "a journal", error.to_string()))
    })
}
