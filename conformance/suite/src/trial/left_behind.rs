//! A case that judges an object changed by an earlier case says nothing about the device's own value.

use super::Trial;
use crate::bench::Bench;
use crate::verdict::Reason;

pub(super) fn judge(mut trial: Trial, bench: &mut Bench<'_>) -> Trial {
    trial.excuse(|breach| {
        let actual = "the value of an earlier case, which could not be restored";
        let duty = || format!("{} has the device's own value", breach.subject);
        bench.changes.is_left_behind(breach.subject).then(|| Reason::new(duty(), "the value before the run", actual))
    });
    trial
}
