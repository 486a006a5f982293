//! Puts the device back after a case. The run continues even if the code that does so panics.

use super::Trial;
use crate::bench::{Bench, Remains, baseline};
use crate::verdict::End;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Puts back the changes of the case, and takes the contents of its report.
pub(super) fn make_idle(trial: Trial, bench: &mut Bench<'_>) -> Trial {
    let ended_early = matches!(trial.end, Some(End::Inconclusive(_) | End::Error(_)));
    let clean_up = || {
        if ended_early {
            trial.case.rescue(bench);
        }
        bench.finish()
    };
    let remains = catch_unwind(AssertUnwindSafe(clean_up)).unwrap_or_else(|_| {
        let notes = vec!["the tester failed while it restored the device".to_owned()];
        Remains { notes, ..Remains::default() }
    });
    Trial { remains, ..trial }
}

/// Puts back stored values and settles the journal; then counts the messages of others.
pub(super) fn settle(trial: Trial, bench: &mut Bench<'_>) -> Trial {
    let settled = catch_unwind(AssertUnwindSafe(|| {
        if trial.has_asked {
            baseline::settle_memory(bench, trial.case.touches);
        }
    }));
    // If the tester fails here, the case stays in the journal.
    if settled.is_ok() {
        bench.changes.settle_journal();
    }
    Trial { foreign: bench.traffic.clients.messages(), ..trial }
}
