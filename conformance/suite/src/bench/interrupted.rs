//! What an interrupted run has left behind is put back by its journal.

use super::baseline::{Baseline, MemoryLeft};
use super::rewrite::Original;
use super::{Bench, Rescue};
use crate::comparison::Comparison;
use crate::journal::{Head, Interrupted};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use std::io;

impl Bench<'_> {
    /// Begins the journal, if one is wanted: no case has run yet.
    pub(crate) fn begin_journal(
        &mut self,
        bus: &str,
        operational: bool,
        dictionary: &[(Multiplexer, Vec<u8>)],
    ) -> io::Result<()> {
        let Some(path) = &self.options.journal else { return Ok(()) };
        let zero_point = self.changes.baseline.zero_point;
        let (node, device, zero_point) = (self.node(), &*self.target.model, zero_point.as_ref());
        self.changes.begin_journal(path, &Head { bus, node, device, operational, dictionary, zero_point })
    }

    /// Puts back what an interrupted run has left behind, where the case that was under way left more than values by its
    /// `rescue`, and compares. `None`: the device does not answer.
    ///
    /// A zero point is not put back: nobody knows whether the shaft is at rest, and by how much it was moved is told.
    pub(crate) fn put_back(&mut self, run: &Interrupted, rescue: Option<Rescue>) -> Option<Comparison> {
        self.uncancelled(|bench| bench.put_back_all(run, rescue))
    }

    fn put_back_all(&mut self, run: &Interrupted, rescue: Option<Rescue>) -> Option<Comparison> {
        self.changes.baseline = Baseline::of(run);
        self.changes.baseline.unseen = run.memory.iter().map(|(at, _)| *at).filter(|at| self.is_unseen(*at)).collect();
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
        let more: Vec<Original> = run.more.iter().map(Original::from).collect();
        // What is not in the dictionary is compared with it.
        let unrestored = self.write_back(&more);
        self.changes.leave(unrestored);
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
            self.changes.baseline.stored =
                Some(run.values.iter().filter(|(at, _)| self.is_put_back(*at)).map(Original::from).collect());
        }
        self.put_back_memory(run.stored, false)
    }
}
