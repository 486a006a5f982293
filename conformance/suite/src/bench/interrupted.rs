//! What an interrupted run has left behind is put back by its journal.

use super::baseline::{Baseline, MemoryLeft};
use super::rewrite::Original;
use super::{Bench, Rescue, baseline, dictionary, rewrite};
use crate::comparison::Comparison;
use crate::journal::{Head, Interrupted};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::wire::nmt::Command;
use std::io;

/// Begins the journal, if one is wanted: no case has run yet.
pub(crate) fn begin_journal(
    bench: &mut Bench<'_>,
    bus: &str,
    operational: bool,
    dictionary: &[(Multiplexer, Vec<u8>)],
) -> io::Result<()> {
    let Some(path) = &bench.options.journal else { return Ok(()) };
    let zero_point = bench.changes.baseline.zero_point;
    let (node, device, zero_point) = (bench.node(), &*bench.target.model, zero_point.as_ref());
    bench.changes.begin_journal(path, &Head { bus, node, device, operational, dictionary, zero_point })
}

/// Puts back what an interrupted run has left behind, where the case that was under way left more than values by its
/// `rescue`, and compares. `None`: the device does not answer.
///
/// A zero point is not put back: nobody knows whether the device is at rest, and by how much it was moved is told.
pub(crate) fn put_back(bench: &mut Bench<'_>, run: &Interrupted, rescue: Option<Rescue>) -> Option<Comparison> {
    bench.uncancelled(|bench| put_back_all(bench, run, rescue))
}

fn put_back_all(bench: &mut Bench<'_>, run: &Interrupted, rescue: Option<Rescue>) -> Option<Comparison> {
    bench.changes.baseline = Baseline::of(run);
    bench.changes.baseline.unseen =
        run.memory.iter().map(|(at, _)| *at).filter(|at| baseline::is_unseen(bench, *at)).collect();
    if let Some(rescue) = rescue {
        // What fails here shows in whether the device answers then.
        let _ = rescue(bench, run.stored);
    }
    // An SDO transfer may be under way, or the device stopped: its reset ends both.
    if !matches!(bench.answers(), Ok(true)) && bench.reset(Command::RESET_NODE).is_err() {
        return None;
    }
    // What fails here shows in what is compared then.
    let memory = put_back_memory_of(bench, run).unwrap_or_default();
    let configured = run.values.iter().filter(|(multiplexer, _)| dictionary::is_put_back(bench, *multiplexer));
    let originals: Vec<Original> = configured.chain(&run.more).map(Original::from).collect();
    rewrite::write_back(bench, &originals);
    bench.leave(run.operational);
    let more: Vec<Original> = run.more.iter().map(Original::from).collect();
    // What is not in the dictionary is compared with it.
    let unrestored = rewrite::write_back(bench, &more);
    bench.changes.leave(unrestored);
    let comparison = dictionary::put_back_dictionary(bench, &run.bus, &run.values);
    Some(baseline::with_memory(bench, comparison, &run.bus, &run.values, memory))
}

/// What the interrupted case stored is put back by storing what a start brought before; where the journal does not hold
/// that, the values that were in use.
fn put_back_memory_of(bench: &mut Bench<'_>, run: &Interrupted) -> Result<MemoryLeft, Stop> {
    if run.memory.is_empty() && !run.stored {
        return Ok(MemoryLeft::default());
    }
    if run.memory.is_empty() {
        bench.changes.baseline.stored =
            Some(run.values.iter().filter(|(at, _)| dictionary::is_put_back(bench, *at)).map(Original::from).collect());
    }
    baseline::put_back_memory(bench, run.stored, false)
}
