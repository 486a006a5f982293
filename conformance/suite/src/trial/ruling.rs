//! The verdict: the remaining breaches are graded, and excused if the device's manual or a waiver announces them.

use super::presence::is_gone;
use super::{CaseReport, Trial};
use crate::bench::{Bench, Remains, Target};
use crate::case::Case;
use crate::clause::Level;
use crate::verdict::{Breach, Deviation, Excuse, Grade, Kind, Ruled, Verdict};

impl Trial {
    /// The report at the end of the trial.
    pub(super) fn report(self, bench: &Bench<'_>) -> CaseReport {
        let Self { case, breaches, end, foreign, started, .. } = self;
        let Remains { evidence, notes, measurements, uses, .. } = self.remains;
        let graded = breaches.into_iter().map(|breach| graded(breach, case));
        let verdict = Verdict::new(graded.map(|breach| rule(breach, case, &bench.target().deviations)).collect(), end);
        let others = foreign.iter().map(ToString::to_string);
        let notes = notes.into_iter().chain(others).chain(described_so(bench, case, &verdict)).collect();
        let outcomes = vec![verdict.kind()];
        let duration = bench.now().since(started);
        CaseReport { case, verdict, evidence, notes, measurements, uses, foreign, outcomes, quarantine: None, duration }
    }
}

/// A note on a failure of a device that is simulated from its description alone: the description causes it, not the
/// simulation.
fn described_so(bench: &Bench<'_>, case: &Case, verdict: &Verdict) -> Option<String> {
    let Target { described_alone, model, .. } = bench.target();
    let is_it = *described_alone && case.asks_the_device() && verdict.kind() == Kind::Fail;
    is_it.then(|| format!("the device is simulated as {model} describes it: the fault is in that description"))
}

/// The breach with its grade. If the standard leaves the behaviour open, the breach is recorded and never fails the
/// case, except that no device may leave the bus.
fn graded(breach: Breach, case: &Case) -> Breach {
    if case.level == Level::Open && !is_gone(&breach) { breach.open() } else { breach }
}

/// Excuses a breach that the device's documentation or its user announces, for exactly this case, subject and
/// behaviour.
fn rule(breach: Breach, case: &Case, deviations: &[Deviation]) -> Ruled {
    let announced = deviations.iter().filter(|_| breach.grade == Grade::Wrong);
    let announced = announced.into_iter().find(|deviation| deviation.explains(case.id, &breach));
    let excuse = announced.map(|Deviation { documented, by, .. }| Excuse { documented: documented.clone(), by: *by });
    Ruled { breach, excuse }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::test_case;
    use crate::verdict::Authority;
    use canvass_analyzer::{Multiplexer, object};
    use canvass_bus::observation::{Observation, Subject};

    /// A run in which the device has left the bus must not pass.
    #[test]
    fn a_device_that_leaves_fails_an_open_case_too() {
        let open = Case { level: Level::Open, ..test_case("test/open", |_| Ok(())) };
        let grade = |found: &'static str| {
            graded(Breach::new(Subject::Device, "it stays").found(Observation::named(found)), &open).grade
        };
        assert_eq!(grade("the device stopped answering"), Grade::Wrong);
        assert_eq!(grade("another state"), Grade::Open);
    }

    #[test]
    fn a_documented_breach_is_a_deviation_and_hides_no_other() {
        let silent = Breach::new(Subject::Device, "it works").found(Observation::Silence);
        let deviations = [Deviation {
            cases: vec!["test/*".to_owned()],
            subject: Some(Subject::Device),
            situation: None,
            does: "silence".parse().unwrap(),
            documented: "manual, 5.1".to_owned(),
            by: Authority::Manual,
        }];
        let case = test_case("test/passes", |_| Ok(()));
        let kind = |breach: &Breach| rule(breach.clone(), &case, &deviations).kind();
        assert_eq!(kind(&silent), Kind::Deviation);
        assert_eq!(kind(&silent.clone().found(Observation::Confirmation)), Kind::Fail, "it does something else");
        let elsewhere = Breach { subject: Multiplexer::new(object::DEVICE_TYPE, 0).into(), ..silent.clone() };
        assert_eq!(kind(&elsewhere), Kind::Fail, "another object does it");
        let other_case = test_case("other/case", |_| Ok(()));
        assert_eq!(rule(silent, &other_case, &deviations).kind(), Kind::Fail);
    }
}
