//! What others on the bus may have made a case find is not blamed on the device.

use super::{CaseReport, run_case};
use crate::bench::Bench;
use crate::case::Case;
use crate::foreign::{ForeignMessages, told};
use crate::touch::Touch;
use crate::verdict::{Breach, End, Kind, Lack, Reason};

/// A case that others disturbed is run again this many times at most.
const REPETITIONS: usize = 3;

/// What remains of the breaches when those that others may have caused are left out, and how the case ended then.
pub(super) fn not_of_others(
    case: &str,
    breaches: Vec<Breach>,
    end: Option<End>,
    messages: &[ForeignMessages],
) -> (Vec<Breach>, Option<End>) {
    if messages.is_empty() || matches!(end, Some(End::NotApplicable(_) | End::Error(_))) {
        return (breaches, end);
    }
    let causes = |breach: &Breach| chosen(messages, |sent| sent.kind.may_cause(breach));
    let (excused, certain): (Vec<Breach>, Vec<Breach>) =
        breaches.into_iter().partition(|breach| !causes(breach).is_empty());
    if let Some(first) = excused.first() {
        return (certain, Some(disturbed(&causes(first), Some(&Reason::from(first)))));
    }
    let end = match end {
        None if certain.is_empty() => {
            let causes = chosen(messages, |sent| sent.kind.may_pass(case));
            (!causes.is_empty()).then(|| disturbed(&causes, None))
        }
        Some(End::Inconclusive(reason)) => {
            let causes = chosen(messages, |sent| sent.kind.may_keep_out());
            Some(if causes.is_empty() { End::Inconclusive(reason) } else { disturbed(&causes, Some(&reason)) })
        }
        end => end,
    };
    (certain, end)
}

fn chosen(messages: &[ForeignMessages], is_it: impl Fn(&ForeignMessages) -> bool) -> Vec<ForeignMessages> {
    messages.iter().copied().filter(is_it).collect()
}

/// Nothing can be said, as others did that; and what was found meanwhile.
fn disturbed(causes: &[ForeignMessages], found: Option<&Reason>) -> End {
    let meanwhile = found.map(|reason| format!("; meanwhile: {} ({})", reason.duty, reason.actual));
    let actual = format!("{}{}", told(causes), meanwhile.unwrap_or_default());
    let reason = Reason::new("nobody else uses the device while the case runs", "no messages of others", actual);
    End::Inconclusive(reason.for_lack_of(Lack::Quiet))
}

/// Runs a case, and again if others disturbed it, or the device was late as a whole. Memory that wears out is not written again.
pub(super) fn run_undisturbed(bench: &mut Bench<'_>, case: &'static Case) -> CaseReport {
    let mut report = run_case(bench, case);
    for _ in 0..REPETITIONS {
        if !may_end_otherwise(&report) || case.touches.contains(&Touch::Nvm) || bench.is_cancelled() {
            break;
        }
        let reason = report.verdict.reason().map(|reason| reason.actual).unwrap_or_default();
        let notes = std::mem::take(&mut report.notes);
        report = run_case(bench, case);
        let tried = format!("tried again: {reason}");
        report.notes.splice(0..0, notes.into_iter().chain([tried]));
    }
    report
}

/// Whether a repetition may find a quieter moment: others that send to the device all the time leave none.
fn may_end_otherwise(report: &CaseReport) -> bool {
    let Some(End::Inconclusive(reason)) = report.verdict.end() else { return false };
    let come_and_go = report.foreign.iter().any(|sent| sent.kind.may_keep_out());
    let is_by_chance = reason.lack == Lack::Quiet && come_and_go || reason.lack == Lack::Promptness;
    report.verdict.kind() == Kind::Inconclusive && is_by_chance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::foreign::ForeignKind;
    use crate::verdict::{Ruled, Verdict};
    use canvass_analyzer::wire::emcy::EmcyCode;
    use canvass_analyzer::wire::error_control::State;
    use canvass_analyzer::wire::sdo::AbortCode;
    use canvass_analyzer::{Multiplexer, Service};
    use canvass_bus::observation::{Observation, Subject};

    fn sent(kinds: &[ForeignKind]) -> Vec<ForeignMessages> {
        kinds.iter().map(|&kind| ForeignMessages { kind, can_id: 0x63F, count: 12 }).collect()
    }

    fn judged(case: &str, breaches: &[Breach], end: Option<End>, kinds: &[ForeignKind]) -> Verdict {
        let (breaches, end) = not_of_others(case, breaches.to_vec(), end, &sent(kinds));
        Verdict::new(breaches.into_iter().map(|breach| Ruled { breach, excuse: None }).collect(), end)
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

    /// What each sort of message explains, and something that it does not.
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

    /// Who else may be why is told where a precondition was not reached; what does not apply, or broke, is left as it is.
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
