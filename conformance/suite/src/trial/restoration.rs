//! The device is put back. That may panic, too; the run goes on.

use super::Trial;
use crate::bench::{Bench, Remains, baseline};
use crate::verdict::End;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Puts back what the case changed, and takes what it leaves for its report.
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

/// Puts back what the case may have stored, and tells the journal; then counts what others have sent.
pub(super) fn settle(trial: Trial, bench: &mut Bench<'_>) -> Trial {
    let settled = catch_unwind(AssertUnwindSafe(|| {
        if trial.has_asked {
            baseline::settle_memory(bench, trial.case.touches);
        }
    }));
    // If the tester fails here, the journal goes on telling of the case.
    if settled.is_ok() {
        bench.changes.settle_journal();
    }
    Trial { foreign: bench.traffic.clients.messages(), ..trial }
}
