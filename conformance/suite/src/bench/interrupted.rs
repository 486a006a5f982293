//! Puts back the changes of an interrupted run, which its journal lists.

use super::baseline::{Baseline, MemoryLeft};
use super::{Bench, Rescue, baseline, dictionary, rewrite};
use crate::comparison::{Change, Comparison};
use crate::journal::{Head, Interrupted};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::dictionary::configuration::Download;
use canvass_analyzer::object::Acting;
use canvass_analyzer::wire::nmt::Command;
use std::io;

/// Begins the journal, if the user wants one. No case has run yet.
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

/// Puts back the changes of an interrupted run, and compares. If the case that was under way may have left more than
/// values, its `rescue` runs first. `None` if the device does not answer.
///
/// A zero point is not put back, because nobody knows whether the device is at rest; the comparison reports its
/// distance.
pub(crate) fn put_back(bench: &mut Bench<'_>, run: &Interrupted, rescue: Option<Rescue>) -> Option<Comparison> {
    bench.uncancelled(|bench| put_back_all(bench, run, rescue))
}

fn put_back_all(bench: &mut Bench<'_>, run: &Interrupted, rescue: Option<Rescue>) -> Option<Comparison> {
    bench.changes.baseline = Baseline::of(run);
    bench.changes.baseline.unseen =
        run.memory.iter().map(|(at, _)| *at).filter(|at| baseline::is_unseen(bench, *at)).collect();
    if let Some(rescue) = rescue {
        // A failure here shows in whether the device answers afterwards.
        let _ = rescue(bench, run.stored);
    }
    // An SDO transfer may be under way, or the device may be stopped: a reset ends both.
    if !matches!(bench.answers(), Ok(true)) && bench.reset(Command::RESET_NODE).is_err() {
        return None;
    }
    // A failure here shows in the comparison.
    let memory = put_back_memory_of(bench, run).unwrap_or_default();
    let configured = run.values.iter().filter(|(multiplexer, _)| dictionary::is_put_back(bench, *multiplexer));
    let originals: Vec<Download> = configured.chain(&run.more).map(Download::from).collect();
    rewrite::write_back(bench, &originals);
    bench.leave(run.operational);
    let more: Vec<Download> = run.more.iter().map(Download::from).collect();
    // These objects are not in the dictionary: they are compared together with it.
    let unrestored = rewrite::write_back(bench, &more);
    bench.changes.leave(unrestored);
    let comparison = dictionary::put_back_dictionary(bench, &run.bus, &run.values);
    Some(baseline::with_memory(bench, comparison, &run.bus, &run.values, memory))
}

/// The presets that the interrupted case may have written and that only power-on shows. The report names them, because
/// nobody can read or write them without moving the zero point.
pub(crate) fn unseen_presets(bench: &mut Bench<'_>, run: &Interrupted) -> Vec<Change> {
    let is_hidden = |at: Multiplexer| {
        bench.acting(at) == Some(Acting::MovesZeroPoint) && bench.stores_at_once(at) && baseline::is_unseen(bench, at)
    };
    let hidden = run.values.iter().filter(|(at, _)| is_hidden(*at));
    hidden.map(|(at, value)| dictionary::change(bench, *at, Some(value.clone()), None)).collect()
}

/// Undoes the stores of the interrupted case: stores the values that a start loaded before the run. If the journal
/// lacks these values, the values that were in use are stored.
fn put_back_memory_of(bench: &mut Bench<'_>, run: &Interrupted) -> Result<MemoryLeft, Stop> {
    if run.memory.is_empty() && !run.stored {
        return Ok(MemoryLeft::default());
    }
    if run.memory.is_empty() {
        bench.changes.baseline.stored =
            Some(run.values.iter().filter(|(at, _)| dictionary::is_put_back(bench, *at)).map(Download::from).collect());
    }
    baseline::put_back_memory(bench, run.stored, false)
}
