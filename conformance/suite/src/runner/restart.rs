//! A device that restarted by itself: what a case found of it afterwards is what a restart leaves.

use crate::bench::{Bench, Boots};
use crate::verdict::{Breach, End};
use canvass_bus::observation::{Observation, Subject};
use canvass_traces::Timestamp;

/// The breaches of a case in the order in which they were seen, that of a restart among them: what follows a restart, such as
/// silence or a state after a reset, does not hide it.
pub(super) fn with_restart(
    bench: &mut Bench<'_>,
    mut breaches: Vec<Breach>,
    end: Option<&End>,
    boots: &Boots,
) -> Vec<Breach> {
    if matches!(end, Some(End::NotApplicable(_) | End::Error(_))) {
        return breaches;
    }
    let has_passed = breaches.is_empty() && end.is_none();
    // A second boot-up message soon after the first one is asked about only where something was lost with it.
    let soon = || boots.second.filter(|_| !has_passed && !bench.boots_twice());
    if let Some(at) = boots.unasked.or_else(soon) {
        let place = breaches.iter().position(|breach| breach.seen.is_none_or(|seen| seen >= at));
        breaches.insert(place.unwrap_or(breaches.len()), restarted_by_itself(at));
    }
    breaches
}

fn restarted_by_itself(at: Timestamp) -> Breach {
    let breach = Breach::new(Subject::Device, "the device does not restart by itself");
    let breach = breach.expected("no boot-up message after the case has begun").found(Observation::BootUp);
    Breach { seen: Some(at), ..breach.told(format!("a boot-up message at {at} s")) }
}
