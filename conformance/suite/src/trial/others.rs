//! Findings that others on the bus may have caused are not blamed on the device.

use super::{Trial, meanwhile};
use crate::bench::Bench;
use crate::foreign::{ForeignMessages, told};
use crate::verdict::{Breach, End, Lack, Reason};

pub(super) fn judge(trial: Trial, _: &mut Bench<'_>) -> Trial {
    let case = trial.case.id;
    not_of_others(trial, case)
}

/// Removes the breaches that others may have caused.
fn not_of_others(mut trial: Trial, case: &str) -> Trial {
    if trial.foreign.is_empty() || trial.is_void() {
        return trial;
    }
    let messages = trial.foreign.clone();
    let excuse = |breach: &Breach| {
        let causes = chosen(&messages, |sent| sent.kind.may_cause(breach));
        (!causes.is_empty()).then(|| disturbed(&causes, Some(&Reason::from(breach))))
    };
    if trial.excuse(excuse) {
        return trial;
    }
    let causes = match &trial.end {
        None if trial.breaches.is_empty() => chosen(&messages, |sent| sent.kind.may_pass(case)),
        Some(End::Inconclusive(_)) => chosen(&messages, |sent| sent.kind.may_keep_out()),
        _ => Vec::new(),
    };
    if !causes.is_empty() {
        trial.end = Some(End::Inconclusive(disturbed(&causes, trial.end.as_ref().map(End::reason))));
    }
    trial
}

fn chosen(messages: &[ForeignMessages], is_it: impl Fn(&ForeignMessages) -> bool) -> Vec<ForeignMessages> {
    messages.iter().copied().filter(is_it).collect()
}

/// The reason that others disturbed the case, with the finding meanwhile, if any.
fn disturbed(causes: &[ForeignMessages], found: Option<&Reason>) -> Reason {
    let actual = format!("{}{}", told(causes), found.map(meanwhile).unwrap_or_default());
    let reason = Reason::new("nobody else uses the device while the case runs", "no messages of others", actual);
    reason.for_lack_of(Lack::Quiet)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foreign::ForeignKind;
    use crate::trial::tests::{trial, verdict};
    use crate::verdict::{Kind, Verdict};
    use canvass_analyzer::wire::emcy::EmcyCode;
    use canvass_analyzer::wire::error_control::State;
    use canvass_analyzer::wire::sdo::AbortCode;
    use canvass_analyzer::{Multiplexer, Service};
    use canvass_bus::observation::{Observation, Subject};

    fn sent(kinds: &[ForeignKind]) -> Vec<ForeignMessages> {
        kinds.iter().map(|&kind| ForeignMessages { kind, can_id: 0x63F, count: 12 }).collect()
    }

    fn judged(case: &str, breaches: &[Breach], end: Option<End>, kinds: &[ForeignKind]) -> Verdict {
        verdict(not_of_others(Trial { foreign: sent(kinds), ..trial(breaches.to_vec(), end) }, case))
    }

    fn breach(subject: impl Into<Subject>, actual: Observation) -> Breach {
        Breach::new(subject, "it works").expected("that").found(actual)
    }

    const READ: ForeignKind = ForeignKind::SdoRead;

    #[test]
    fn a_breach_that_others_may_have_caused_is_inconclusive() {
        let silent = breach(Multiplexer::new(0x1000, 0), Observation::Silence);
        let verdict = judged("301/sdo/x", std::slice::from_ref(&silent), None, &[READ]);
        let Some(End::Inconclusive(reason)) = verdict.end() else { panic!("{verdict:?}") };
        assert_eq!((verdict.kind(), reason.lack), (Kind::Inconclusive, Lack::Quiet));
        assert_eq!(
            reason.actual,
            "another SDO client reads its objects (12 frames with CAN-ID 63F); meanwhile: it works (no answer)"
        );
        let late = breach(Service::Heartbeat, Observation::Silence);
        assert_eq!(
            judged("301/x", &[silent.clone(), late], None, &[READ]).kind(),
            Kind::Fail,
            "reads delay no heartbeat"
        );
        assert_eq!(judged("301/sdo/x", &[silent], None, &[]).kind(), Kind::Fail);
    }

    /// Breaches that each kind of message explains, and breaches that it does not explain.
    #[test]
    fn each_sort_explains_what_it_may_cause() {
        let entry = |index| Subject::Entry(Multiplexer::new(index, 1));
        let tpdo = Subject::Pdo { transmit: true, number: 1 };
        let emcy = || Observation::Emcy(EmcyCode::HEARTBEAT);
        let value = || Observation::Value(vec![0]);
        let count = || Observation::Count(2);
        let rows = [
            (READ, breach(entry(0x1017), Observation::Abort(AbortCode::GENERAL)), breach(tpdo, count())),
            (ForeignKind::Sync, breach(tpdo, count()), breach(entry(0x1017), value())),
            (ForeignKind::Time, breach(Service::Time, count()), breach(tpdo, count())),
            (ForeignKind::Rpdo, breach(entry(0x6200), value()), breach(Service::Heartbeat, value())),
            (ForeignKind::LayerSetting, breach(Service::Lss, Observation::Silence), breach(tpdo, count())),
            (ForeignKind::Guarding, breach(Service::Guarding, value()), breach(tpdo, count())),
            (ForeignKind::Heartbeat, breach(Subject::Device, emcy()), breach(tpdo, count())),
        ];
        for (kind, explained, other) in rows {
            assert_eq!(judged("x", &[explained], None, &[kind]).kind(), Kind::Inconclusive, "{kind}");
            assert_eq!(judged("x", &[other], None, &[kind]).kind(), Kind::Fail, "{kind}");
        }
        let anything = breach(Subject::Device, Observation::State(State::STOPPED));
        for kind in [ForeignKind::SdoWrite, ForeignKind::Nmt] {
            assert_eq!(
                judged("x", std::slice::from_ref(&anything), None, &[kind]).kind(),
                Kind::Inconclusive,
                "{kind}"
            );
        }
    }

    #[test]
    fn a_pass_that_counts_what_others_send_says_nothing() {
        let kind = |case: &str, kind| judged(case, &[], None, &[kind]).kind();
        assert_eq!(kind("301/tpdo/sync-cycle", ForeignKind::Sync), Kind::Inconclusive);
        assert_eq!(kind("301/sdo/upload/name", ForeignKind::Sync), Kind::Pass);
        assert_eq!(kind("301/tpdo/sync-cycle", READ), Kind::Pass);
        assert_eq!(kind("305/identify/all", ForeignKind::LayerSetting), Kind::Inconclusive);
    }

    /// If a precondition was not reached, the report names others that may be the cause; cases that do not apply or
    /// broke are unchanged.
    #[test]
    fn who_may_keep_a_case_from_its_precondition_is_told() {
        let reason = || Reason::new("it is reached", "yes", "no");
        let told = |end, kind| judged("x", &[], Some(end), &[kind]).reason().unwrap().actual;
        let inconclusive = || End::Inconclusive(reason());
        assert!(
            told(inconclusive(), READ).ends_with("; meanwhile: it is reached (no)"),
            "{}",
            told(inconclusive(), READ)
        );
        assert_eq!(told(inconclusive(), ForeignKind::Sync), "no");
        assert_eq!(told(End::NotApplicable(reason()), READ), "no");
        assert_eq!(told(End::Error(reason()), READ), "no");
    }

    /// Patterns that match no case would void no pass.
    #[test]
    fn the_cases_whose_pass_is_void_exist() {
        let cases = crate::catalogue::cases();
        for kind in ForeignKind::ALL.into_iter().filter(|kind| !matches!(*kind, READ | ForeignKind::SdoWrite)) {
            let void = cases.iter().filter(|case| kind.may_pass(case.id)).count();
            assert!((3..cases.len() / 5).contains(&void), "{kind}: {void} cases");
        }
        assert!(crate::foreign::unmatched(&cases.iter().map(|case| case.id).collect::<Vec<_>>()).is_empty());
    }
}
