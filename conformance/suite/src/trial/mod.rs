//! One case from its precondition to its verdict.

mod attempt;
mod hindrance;
mod kept_out;
mod lateness;
mod left_behind;
mod others;
mod presence;
mod report;
mod restart;
mod restoration;
mod ruling;

pub(crate) use lateness::doubt;
pub use report::CaseReport;

use crate::bench::{Bench, Remains};
use crate::case::Case;
use crate::foreign::ForeignMessages;
use crate::verdict::{Breach, End, Reason};
use canvass_bus::Health;
use canvass_traces::Timestamp;

/// A case that was run: the breaches that the device is blamed for, and what its judges need to know.
#[derive(Debug)]
pub(crate) struct Trial {
    case: &'static Case,
    breaches: Vec<Breach>,
    /// Why the case did not come to its own end.
    end: Option<End>,
    /// The precondition that the case itself did not reach.
    unreached: Option<Reason>,
    /// The case has asked the device, and nothing on the tester's side kept the device from answering.
    has_asked: bool,
    /// The device left the bus during the case.
    has_left: bool,
    /// Who took so much of the bus that the device may not have got through.
    overload: Option<String>,
    /// What others sent to the device or for it during the case.
    foreign: Vec<ForeignMessages>,
    remains: Remains,
    started: Timestamp,
    /// How well bus and tester worked before the case.
    health: Health,
}

/// Takes a trial and gives it back with the breaches that are still the device's.
type Judge = fn(Trial, &mut Bench<'_>) -> Trial;

/// The judges in their order, which matters: each may change the device, and so what the next one finds.
const JUDGES: [Judge; 10] = [
    // Putting the device back makes the bench forget what an earlier case has left behind.
    left_behind::judge,
    // A device that has gone is looked for while its frames are still evidence.
    presence::look,
    restoration::make_idle,
    // A restart explains what came after it, so it goes before the excuses of single breaches.
    restart::judge,
    hindrance::judge,
    kept_out::judge,
    // The memory is put back once nobody needs the device as the case left it, and before messages of others are counted.
    restoration::settle,
    presence::judge,
    others::judge,
    // Asks the device most, and only for breaches that nothing else explains.
    lateness::judge,
];

/// Runs one case: precondition, stimulus, restoration, and what must be true after every case.
pub fn run_case(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let trial = attempt::run(Trial::new(bench, case), bench);
    JUDGES.iter().fold(trial, |trial, judge| judge(trial, bench)).report(bench)
}

impl Trial {
    fn new(bench: &Bench<'_>, case: &'static Case) -> Self {
        Self::at(case, bench.now(), bench.health())
    }

    fn at(case: &'static Case, started: Timestamp, health: Health) -> Self {
        Self {
            case,
            breaches: Vec::new(),
            end: None,
            unreached: None,
            has_asked: false,
            has_left: false,
            overload: None,
            foreign: Vec::new(),
            remains: Remains::default(),
            started,
            health,
        }
    }

    /// Whether the case passes as far as it was judged.
    const fn has_passed(&self) -> bool {
        self.breaches.is_empty() && self.end.is_none()
    }

    /// Whether the case has not come to a verdict on the device: there is nothing to excuse.
    const fn is_void(&self) -> bool {
        matches!(self.end, Some(End::NotApplicable(_) | End::Error(_)))
    }

    /// Leaves out the breaches that have an excuse; the excuse of the first makes the case inconclusive. `true`: there was one.
    fn excuse(&mut self, excuse: impl Fn(&Breach) -> Option<Reason>) -> bool {
        let mut first = None;
        self.breaches.retain(|breach| match excuse(breach) {
            Some(reason) => {
                first.get_or_insert(reason);
                false
            }
            None => true,
        });
        let is_excused = first.is_some();
        self.end = first.map(End::Inconclusive).or(self.end.take());
        is_excused
    }

    /// The first breach, or why the case ended; empty if it has passed.
    fn meanwhile(&self) -> String {
        let ended = || self.end.as_ref().map(|end| end.reason().clone());
        self.breaches.first().map(Reason::from).or_else(ended).map(|reason| meanwhile(&reason)).unwrap_or_default()
    }
}

/// What was found while something else kept the case from a verdict.
fn meanwhile(found: &Reason) -> String {
    format!("; meanwhile: {} ({})", found.duty, found.actual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::test_case;
    use crate::verdict::{Ruled, Verdict};

    static CASE: Case = test_case("test/tried", |_| Ok(()));

    /// A case that ended so; the bus and the tester had no trouble before it.
    pub(super) fn trial(breaches: Vec<Breach>, end: Option<End>) -> Trial {
        Trial { breaches, end, ..Trial::at(&CASE, Timestamp::ZERO, Health::default()) }
    }

    /// Its verdict, if nothing is documented.
    pub(super) fn verdict(trial: Trial) -> Verdict {
        Verdict::new(trial.breaches.into_iter().map(|breach| Ruled { breach, excuse: None }).collect(), trial.end)
    }
}
