//! A device that restarted by itself: what a case found of it afterwards is what a restart leaves.

use super::Trial;
use crate::bench::Bench;
use crate::verdict::Breach;
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Timestamp;

/// Puts the breach of a restart in its place in time: it hides what follows it, such as silence or a state after a reset, and not
/// what came before.
pub(super) fn judge(mut trial: Trial, bench: &mut Bench<'_>) -> Trial {
    if trial.is_void() {
        return trial;
    }
    let boots = trial.remains.boots;
    // A second boot-up message soon after the first one is asked about only where something was lost with it.
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
