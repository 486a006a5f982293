//! A device that left the bus. Even a case that passed may have stopped it.

use super::Trial;
use super::attempt::regain;
use crate::bench::Bench;
use crate::verdict::Breach;
use canvass_bus::observation::{Observation, Subject};

/// The observation that the device has left.
const GONE: &str = "the device stopped answering";

/// Whether a breach says that the device has left the bus. No case leaves that open, whatever its own level.
pub(crate) fn is_gone(breach: &Breach) -> bool {
    matches!(&breach.actual, Observation::Named(found) if found == GONE)
}

/// Checks whether the device is still present, if the case has asked it.
pub(super) fn look(trial: Trial, bench: &mut Bench<'_>) -> Trial {
    let was_interrupted = bench.health().since(&trial.health).interruptions > 0;
    let has_asked = trial.case.asks_the_device() && !was_interrupted && !trial.is_void();
    let has_left = has_asked && bench.has_left(trial.case.id, regain);
    Trial { has_asked, has_left, ..trial }
}

/// Fails the case if the device has left, whatever else the case found.
pub(super) fn judge(mut trial: Trial, _: &mut Bench<'_>) -> Trial {
    let gone = || {
        Breach::new(Subject::Device, "the device stays on the bus")
            .expected("an answer, or a start after a reset")
            .found(Observation::named(GONE))
    };
    trial.breaches.extend(trial.has_left.then(gone));
    trial
}
