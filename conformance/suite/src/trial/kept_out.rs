//! A case that needs the device operational says nothing about a device that can't become operational. The cases on its
//! state report this fault, or the case after which the device could no longer become operational.

use super::Trial;
use crate::bench::{Bench, KeptOut};
use crate::clause::Level;
use crate::verdict::{Breach, End};
use canvass_analyzer::Service;
use canvass_analyzer::wire::error_control::State;
use canvass_bus::observation::{Observation, Subject};

pub(super) fn judge(trial: Trial, bench: &mut Bench<'_>) -> Trial {
    let judges_states = matches!(trial.case.family(), "301/nmt" | "301/heartbeat" | "301/guarding");
    let is_doubtful =
        trial.breaches.iter().any(needs_operational) || trial.has_passed() && !bench.knowledge.may_be_operational();
    if !trial.has_asked || trial.has_left || judges_states || !bench.has_started_it() || !is_doubtful {
        return trial;
    }
    let may_fail = trial.case.level != Level::Open;
    match bench.kept_out_of_operational(may_fail.then_some(trial.case.id)) {
        None => trial,
        Some(KeptOut::Newly(breach)) => {
            Trial { breaches: trial.breaches.into_iter().chain([breach]).collect(), ..trial }
        }
        Some(KeptOut::Known(reason)) => {
            let others = trial.breaches.into_iter().filter(|breach| !needs_operational(breach)).collect();
            Trial { breaches: others, end: Some(End::Inconclusive(reason)), ..trial }
        }
    }
}

/// Whether a breach may show only that the device is not operational: its state, PDOs that don't come or have no
/// effect, and their consequences. SDO works in pre-operational, too.
fn needs_operational(breach: &Breach) -> bool {
    let is_application = |subject| matches!(subject, Subject::Entry(at) if at.index.0 >= 0x2000);
    let is_of_sdo = match breach.subject {
        Subject::Service(service) => service == Service::Sdo,
        subject => matches!(subject, Subject::Entry(_) | Subject::Object(_)) && !is_application(subject),
    };
    match breach.actual {
        Observation::State(state) => state != State::OPERATIONAL,
        Observation::Count(_) | Observation::Time(_) => true,
        Observation::Silence | Observation::Named(_) => !is_of_sdo,
        Observation::Value(_) => is_application(breach.subject),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::wire::sdo::AbortCode;

    fn breach(actual: Observation) -> Breach {
        Breach::new(Subject::Device, "the read is answered").expected("the value").found(actual)
    }

    /// Breaches that a device shows because it is not operational, and breaches that no device shows for that reason.
    #[test]
    fn what_the_state_explains() {
        let tpdo = Subject::Pdo { transmit: true, number: 1 };
        let entry = |index| Subject::Entry(canvass_analyzer::Multiplexer::new(index, 0));
        let found = |subject, actual| needs_operational(&Breach { subject, ..breach(actual) });
        for (subject, actual) in [
            (tpdo, Observation::Silence),
            (tpdo, Observation::Count(0)),
            (Subject::Device, Observation::State(State::PRE_OPERATIONAL)),
            (Subject::Device, Observation::named("no EMCY, but the state")),
            (entry(0x2000), Observation::Value(vec![0])),
        ] {
            assert!(found(subject, actual.clone()), "{subject:?} {actual:?}");
        }
        for (subject, actual) in [
            (Subject::Device, Observation::State(State::OPERATIONAL)),
            (entry(0x1017), Observation::Silence),
            (entry(0x1017), Observation::Value(vec![0])),
            (Subject::Service(Service::Sdo), Observation::named("seven bytes")),
            (tpdo, Observation::Abort(AbortCode::GENERAL)),
            (Subject::Device, Observation::BootUp),
        ] {
            assert!(!found(subject, actual.clone()), "{subject:?} {actual:?}");
        }
    }
}
