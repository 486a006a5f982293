//! A single case from its precondition to its verdict.

mod attempt;
mod hindrance;
mod kept_out;
mod lateness;
mod left_behind;
mod motion;
mod others;
mod presence;
mod report;
mod restart;
mod restoration;
mod ruling;

pub(crate) use presence::is_gone;
pub use report::CaseReport;

use crate::bench::{Bench, Remains};
use crate::case::Case;
use crate::foreign::ForeignMessages;
use crate::verdict::{Breach, End, Reason};
use canvass_bus::Health;
use canvass_traces::Timestamp;

/// A case that has run: the breaches that are still blamed on the device, and the facts that its judges need.
#[derive(Debug)]
pub(crate) struct Trial {
    case: &'static Case,
    breaches: Vec<Breach>,
    /// The reason why the case ended early.
    end: Option<End>,
    /// The precondition that the case itself did not reach.
    unreached: Option<Reason>,
    /// Whether the case has asked the device, and nothing on the tester's side kept the device from answering.
    has_asked: bool,
    /// Whether the device left the bus during the case.
    has_left: bool,
    /// The others that loaded the bus so much that the device's frames may not have got through.
    overload: Option<String>,
    /// The messages that others sent to the device or for it during the case.
    foreign: Vec<ForeignMessages>,
    remains: Remains,
    started: Timestamp,
    /// The state of the bus and the tester before the case.
    health: Health,
}

/// A judge takes a trial and returns it without the breaches that have an excuse.
type Judge = fn(Trial, &mut Bench<'_>) -> Trial;

/// The judges in their order. The order matters: each may change the device, and so the findings of the next.
const JUDGES: [Judge; 10] = [
    // Putting the device back makes the bench forget the changes that an earlier case left.
    left_behind::judge,
    // The tester looks for a device that has gone while its frames are still evidence.
    presence::look,
    restoration::make_idle,
    // A restart explains the later breaches, so it comes before the excuses of single breaches.
    restart::judge,
    hindrance::judge,
    kept_out::judge,
    // The memory is put back when no judge needs the device in its state after the case, and before messages of others
    // are counted.
    restoration::settle,
    presence::judge,
    others::judge,
    // This judge asks the device most, and only for breaches that nothing else explains.
    lateness::judge,
];

/// Runs one case: precondition, stimulus, restoration, and the checks after every case.
pub fn run_case(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let trial = attempt::run(Trial::new(bench, case), bench);
    JUDGES.iter().fold(trial, |trial, judge| judge(trial, bench)).report(bench)
}

/// The reason to doubt a failure until it comes again, if there is one.
pub(crate) fn doubt(report: &CaseReport, bench: &Bench<'_>) -> Option<Reason> {
    lateness::doubt(report, bench).or_else(|| motion::doubt(report))
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

    /// Whether the case passes so far.
    const fn has_passed(&self) -> bool {
        self.breaches.is_empty() && self.end.is_none()
    }

    /// Whether the case has no verdict on the device, so that there is nothing to excuse.
    const fn is_void(&self) -> bool {
        matches!(self.end, Some(End::NotApplicable(_) | End::Error(_)))
    }

    /// Removes the breaches that have an excuse. The excuse of the first of these breaches makes the case inconclusive.
    /// Returns whether any breach had an excuse.
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

    /// The first breach, or the reason why the case ended; empty if it has passed.
    fn meanwhile(&self) -> String {
        let ended = || self.end.as_ref().map(|end| end.reason().clone());
        self.breaches.first().map(Reason::from).or_else(ended).map(|reason| meanwhile(&reason)).unwrap_or_default()
    }
}

/// Words for a finding in a case that got no verdict for another reason.
fn meanwhile(found: &Reason) -> String {
    format!("; meanwhile: {} ({})", found.duty, found.actual)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scripted::test_case;
    use crate::verdict::{Ruled, Verdict};

    static CASE: Case = test_case("test/tried", |_| Ok(()));

    /// A case with these breaches and this end. The bus and the tester had no trouble before it.
    pub(super) fn trial(breaches: Vec<Breach>, end: Option<End>) -> Trial {
        Trial { breaches, end, ..Trial::at(&CASE, Timestamp::ZERO, Health::default()) }
    }

    /// The verdict of a trial, if nothing is documented.
    pub(super) fn verdict(trial: Trial) -> Verdict {
        Verdict::new(trial.breaches.into_iter().map(|breach| Ruled { breach, excuse: None }).collect(), trial.end)
    }
}
