//! A device that restarted by itself: later findings of the case show the state after the restart.

use super::Trial;
use crate::bench::Bench;
use crate::verdict::Breach;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Timestamp;

/// Inserts the breach of a restart at its time. It hides later breaches, such as silence or a state after a reset, but
/// not earlier ones.
pub(super) fn judge(mut trial: Trial, bench: &mut Bench<'_>) -> Trial {
    if trial.is_void() {
        return trial;
    }
    let boots = trial.remains.boots;
    // Whether a second boot-up message soon after the first is a restart is checked only if the case found a breach.
    let soon = || boots.second.filter(|_| !trial.has_passed() && !bench.boots_twice());
    if let Some(at) = boots.unasked.or_else(soon) {
        let place = trial.breaches.iter().position(|breach| breach.seen.is_none_or(|seen| seen >= at));
        trial.breaches.insert(place.unwrap_or(trial.breaches.len()), restarted_by_itself(at));
    }
    trial
}

fn restarted_by_itself(at: Timestamp) -> Breach {
    let breach = Breach::new(Subject::Device, "the device does not restart by itself");
    let breach = breach.expected("no boot-up message after the case has begun").found(Observation::BootUp);
    Breach { seen: Some(at), ..breach.told(format!("a boot-up message at {at} s")) }
}
