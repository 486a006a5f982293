//! The attempt at a case: its precondition, its needs, and its stimulus.

use super::Trial;
use super::hindrance::overload;
use crate::bench::{Bench, baseline};
use crate::case::Case;
use crate::needs;
use crate::touch::Touch;
use crate::verdict::{Breach, End, Judged, Lack, Reason, Stop};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs the case, and collects its breaches.
pub(super) fn run(trial: Trial, bench: &mut Bench<'_>) -> Trial {
    bench.begin();
    let judged = catch_unwind(AssertUnwindSafe(|| attempt(bench, trial.case)));
    let judged = judged.unwrap_or_else(|panic| Err(Stop::Error(panicked(&*panic))));
    let (last, end) = ended(judged);
    let breaches = bench.take_breaches(last);
    let took = bench.now().since(trial.started);
    let overload = (!breaches.is_empty()).then(|| overload(bench, took)).flatten();
    let unreached = match &end {
        Some(End::Inconclusive(reason)) if reason.lack == Lack::Feature => Some(reason.clone()),
        _ => None,
    };
    Trial { breaches, end, unreached, overload, ..trial }
}

fn attempt(bench: &mut Bench<'_>, case: &'static Case) -> Judged {
    if let Some(touch) = case.touches.iter().find(|touch| !bench.options().allow.contains(touch)) {
        return Err(Stop::NotApplicable(not_allowed(*touch)));
    }
    if case.touches.contains(&Touch::FactoryDefaults) && baseline::would_lose_zero_point(bench) {
        return Err(Stop::NotApplicable(not_allowed(Touch::Preset)));
    }
    if case.asks_the_device() {
        bench.traffic.end_when_frames_are_lost();
        bench.look_for_it()?;
        prepare(bench)?;
    }
    bench.changes.begin_case(case.id, case.touches)?;
    case.require(bench)?;
    (case.run)(bench)
}

/// Resets the device. An earlier command of a case may take effect only now: the device may have lost its node-ID, for
/// example.
fn prepare(bench: &mut Bench<'_>) -> Judged {
    match bench.prepare() {
        Err(Stop::Inconclusive(_)) if bench.options().allow.contains(&Touch::NodeId) && !bench.is_cancelled() => {
            regain(bench);
            bench.prepare()
        }
        prepared => prepared,
    }
}

/// Restores the node-ID of a device that has lost it, if the user allows that.
pub(super) fn regain(bench: &mut Bench<'_>) {
    let may_regain = bench.options().allow.contains(&Touch::NodeId);
    if let Some(rescue) = needs::LSS.rescue().filter(|_| may_regain) {
        // A failure here shows in whether the device answers afterwards.
        let _ = rescue(bench, true);
    }
}

/// The breach that ended a case, or the other reason why it ended early.
fn ended(judged: Judged) -> (Option<Box<Breach>>, Option<End>) {
    match judged {
        Ok(()) => (None, None),
        Err(Stop::Breach(breach)) => (Some(breach), None),
        Err(Stop::Inconclusive(reason)) => (None, Some(End::Inconclusive(reason))),
        Err(Stop::NotApplicable(reason)) => (None, Some(End::NotApplicable(reason))),
        Err(Stop::Error(reason)) => (None, Some(End::Error(reason))),
    }
}

fn not_allowed(touch: Touch) -> Reason {
    let duty = format!("the user allows the action of the case: it {}", touch.text());
    Reason::new(duty, touch.name(), format!("not allowed: it {}", touch.text())).for_lack_of(Lack::Permission)
}

fn panicked(panic: &(dyn Any + Send)) -> Reason {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned());
    Reason::new("the tester works", "a verdict", text.unwrap_or_else(|| "a panic".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Options;
    use crate::scripted::{table, with_options};
    use canvass_traces::Duration;

    /// If the user has not allowed changes of the node-ID, a device that does not start is reset, brought to
    /// pre-operational and reset again. If the user has allowed them, the tester then restores the node-ID and resets
    /// the device once more in the same way. After the end of the run nothing more is tried.
    #[test]
    fn a_node_id_is_looked_for_with_leave_only() {
        let resets = |allow: &[Touch], limit: Option<Duration>| {
            let options = Options { allow: allow.iter().copied().collect(), limit, ..Options::default() };
            with_options(table(&[]), &options, |bench| {
                assert!(prepare(bench).is_err());
                bench.evidence().frames().filter(|exhibit| exhibit.text == "000#813F").count()
            })
        };
        assert_eq!(resets(&[], None), 2);
        assert_eq!(resets(&[Touch::Nvm], None), 2);
        assert_eq!(resets(&[Touch::NodeId], None), 4);
        assert_eq!(resets(&[Touch::NodeId], Some(Duration::from_secs(15))), 2, "its time was over");
    }
}
