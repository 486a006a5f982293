//! A comparison of two results of `canvass test --format json`: the changes from one release of a firmware to the next.

mod json;
mod report;

pub use crate::results::compare::Direction;

use crate::provenance::Provenance;
use crate::results::TestResult;
use crate::results::compare::Change;
use crate::results::test::{Case, Measurement, ObjectRead, Quarantine, Reason};
use crate::time::milliseconds;
use canvass_suite::verdict::Kind;
use canvass_traces::Duration;
use serde_json::Value;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// A measured time counts as unchanged if it differs by less than this percentage.
pub(crate) const NOTICEABLE_PERCENT: u64 = 10;

/// A measured time counts as unchanged if it differs by less than this time, whatever the percentage, because timers
/// and buses jitter.
const NOTICEABLE_NS: u64 = 1_000_000;

impl Direction {
    /// All directions, the worst first.
    pub const ALL: [Self; 4] = [Self::Worse, Self::Waived, Self::Better, Self::Other];

    const fn title(self) -> &'static str {
        match self {
            Self::Worse => "Worse",
            Self::Waived => "Waived since",
            Self::Better => "Better",
            Self::Other => "Other changes",
        }
    }

    /// The word for the direction in JSON.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Worse => "worse",
            Self::Waived => "waived",
            Self::Better => "better",
            Self::Other => "other",
        }
    }
}

/// All differences, the worst first.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Comparison {
    /// The names of the two releases; empty if they are unknown.
    pub releases: [String; 2],
    /// All differences: regressions first, then what is waived since, improvements, and the rest.
    pub changes: Vec<Change>,
    /// The provenance of the comparison.
    pub provenance: Provenance,
}

impl Change {
    /// A change that is neither worse nor better.
    fn other(kind: &'static str, subject: &str, old: Option<String>, new: Option<String>) -> Self {
        let (kind, subject) = (kind.into(), subject.to_owned());
        Self { direction: Direction::Other, kind, new, old, reason: None, returned: None, subject }
    }

    /// The old and the new value for people.
    fn values(&self) -> (&str, &str) {
        (self.old.as_deref().unwrap_or("-"), self.new.as_deref().unwrap_or("-"))
    }

    /// Whether the change is a case that ran in the new result and counts as worse.
    fn is_regression(&self) -> bool {
        self.kind == "verdict" && self.direction == Direction::Worse && self.new.is_some()
    }

    /// The reason of the change for people. It begins with the fact that an error has returned, if it has.
    fn why(&self) -> Option<String> {
        let returned = self.returned.as_ref().map(|release| format!("again: it was bad in {release}"));
        let parts: Vec<String> = returned.into_iter().chain(self.reason.clone()).collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

/// The rating of cases that are only in the old result.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Missing {
    /// A case that is no longer tested counts as worse.
    #[default]
    Worse,
    /// The case was left out on purpose.
    Allowed,
}

/// Compares two results. The caller, who has read them, adds the provenance.
pub fn compare(old: &TestResult, new: &TestResult, missing: Missing) -> Comparison {
    let mut changes = verdicts(old, new, missing);
    changes.extend(new.cancelled.then(cancelled));
    changes.extend(timings(old, new));
    changes.extend(identity(old, new));
    changes.extend(dictionary(old, new));
    changes.sort_by_key(|change| change.direction);
    Comparison { changes, ..Comparison::default() }
}

/// A cancelled run says nothing about the remaining cases, which counts as worse.
fn cancelled() -> Change {
    let new = Some("cancelled".to_owned());
    Change { direction: Direction::Worse, ..Change::other("run", "the new run", None, new) }
}

fn verdicts(old: &TestResult, new: &TestResult, missing: Missing) -> Vec<Change> {
    let by_id = |result: &TestResult| -> BTreeMap<String, Case> {
        result.cases.iter().map(|case| (case.id.to_string(), case.clone())).collect()
    };
    pairs(&by_id(old), &by_id(new), |id, old, new| {
        let kind = |case: &Case| case.verdict.0;
        let direction = match (old.map(kind), new.map(kind)) {
            (Some(old), Some(new)) if old == new => return None,
            // A case in quarantine is shown, but does not count.
            _ if new.is_some_and(|case| case.quarantine.is_some()) => Direction::Other,
            // A failure that somebody accepts is not mended.
            (Some(Kind::Fail), Some(Kind::Deviation)) if new.is_some_and(|case| case.waiver_line.is_some()) => {
                Direction::Waived
            }
            (Some(old), Some(new)) => match new.badness().cmp(&old.badness()) {
                Ordering::Greater => Direction::Worse,
                Ordering::Less => Direction::Better,
                Ordering::Equal => Direction::Other,
            },
            // A new case that is bad counts as worse, although there is no earlier verdict.
            (None, Some(new)) if new.badness() >= Kind::Inconclusive.badness() => Direction::Worse,
            (Some(old), None) if old.is_executed() && missing == Missing::Worse => Direction::Worse,
            _ => Direction::Other,
        };
        let name = |case: &Case| case.verdict.0.name().to_owned();
        let change = Change::other("verdict", id, old.map(name), new.map(name));
        let reason = match direction {
            Direction::Waived => new.and_then(|case| case.documented.clone()),
            _ => new.and_then(why),
        };
        Some(Change { direction, reason, ..change })
    })
}

/// The reason why a case is not good, and the end of its quarantine.
fn why(case: &Case) -> Option<String> {
    let Reason { duty, expected, actual } = case.reason.as_ref()?;
    let told = |Quarantine { until, owner, .. }: &Quarantine| format!("in quarantine until {until} ({owner}); ");
    let quarantine = case.quarantine.as_ref().map(told).unwrap_or_default();
    Some(format!("{quarantine}{duty}: expected {expected}, found {actual}"))
}

fn timings(old: &TestResult, new: &TestResult) -> Vec<Change> {
    let by_name = |result: &TestResult| -> BTreeMap<String, Measurement> {
        let of_case = |case: &Case| {
            let id = case.id.clone();
            case.measurements.clone().into_iter().map(move |m| (format!("{id}: {}", m.name), m))
        };
        result.cases.iter().flat_map(of_case).collect()
    };
    pairs(&by_name(old), &by_name(new), |name, old, new| {
        let (old, new) = (old?, new?);
        let (difference, is_time) = (new.value.abs_diff(old.value), new.unit == "ns");
        let is_noticeable = difference.saturating_mul(100) > old.value.saturating_mul(NOTICEABLE_PERCENT)
            && (!is_time || difference > NOTICEABLE_NS);
        let shown =
            |m: &Measurement| if is_time { milliseconds(Duration(m.value)) + " ms" } else { m.value.to_string() };
        // A changed time is an error only if a case judges it so. Then the verdict of this case changes, too.
        is_noticeable.then(|| Change::other("timing", name, Some(shown(old)), Some(shown(new))))
    })
}

fn identity(old: &TestResult, new: &TestResult) -> Vec<Change> {
    let by_member = |result: &TestResult| -> BTreeMap<String, String> {
        let members = serde_json::to_value(&result.device).ok();
        let members = members.iter().filter_map(Value::as_object).flatten();
        members.map(|(name, value)| (name.clone(), value.to_string())).collect()
    };
    differences("identity", &by_member(old), &by_member(new))
}

fn dictionary(old: &TestResult, new: &TestResult) -> Vec<Change> {
    let by_address = |result: &TestResult| -> BTreeMap<String, String> {
        let row = |object: &ObjectRead| (format!("{:04X}h:{:02X}", object.index, object.sub), object.data.clone());
        result.dictionary.iter().map(row).collect()
    };
    differences("dictionary", &by_address(old), &by_address(new))
}

fn differences(kind: &'static str, old: &BTreeMap<String, String>, new: &BTreeMap<String, String>) -> Vec<Change> {
    pairs(old, new, |subject, old, new| (old != new).then(|| Change::other(kind, subject, old.cloned(), new.cloned())))
}

/// All keys of both maps, each with its value in either map.
fn pairs<T>(
    old: &BTreeMap<String, T>,
    new: &BTreeMap<String, T>,
    compare: impl Fn(&str, Option<&T>, Option<&T>) -> Option<Change>,
) -> Vec<Change> {
    let gone = old.keys().filter(|key| !new.contains_key(*key));
    let keys = new.keys().chain(gone);
    keys.filter_map(|key| compare(key, old.get(key), new.get(key))).collect()
}

impl Comparison {
    /// Whether a change is for the worse.
    pub fn has_regressions(&self) -> bool {
        self.changes.iter().any(|change| change.direction == Direction::Worse)
    }

    fn of(&self, direction: Direction) -> impl Iterator<Item = &Change> {
        self.changes.iter().filter(move |change| change.direction == direction)
    }

    /// Marks a regression as returned if its case was already bad in one of the releases `earlier`, which come before
    /// the two compared releases. `earlier` is sorted, oldest first; the latest such release is named.
    pub fn recall(&mut self, earlier: &[(String, TestResult)]) {
        let was_bad = |(_, result): &&(String, TestResult), id: &str| result.failed().any(|failed| failed == id);
        for change in self.changes.iter_mut().filter(|change| change.is_regression()) {
            let last = earlier.iter().rev().find(|release| was_bad(release, &change.subject));
            change.returned = last.map(|(release, _)| release.clone());
        }
    }

    /// The outcome in one line.
    fn outcome(&self) -> String {
        let returned = match self.changes.iter().filter(|change| change.returned.is_some()).count() {
            0 => String::new(),
            count => format!(", {count} of them again"),
        };
        match (self.changes.len(), self.of(Direction::Worse).count()) {
            (0, _) => "no difference".to_owned(),
            (all, 0) => format!("{all} differences, nothing got worse"),
            (all, worse) => format!("{all} differences, {worse} for the worse{returned}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::{Form, Report, Style};
    use crate::results;
    use canvass_analyzer::object;
    use serde_json::json;

    fn result(verdict: &str, software: &str, period: u64, value: &str) -> TestResult {
        let text = json!({
            "schema": "canvass/test/1",
            "device": { "software_version": software },
            "dictionary": [{ "index": object::PRODUCER_HEARTBEAT_TIME, "sub": 0, "data": value }],
            "cases": [{
                "id": "301/heartbeat/period", "verdict": verdict,
                "reason": if verdict == "fail" { json!({ "duty": "d", "expected": "e", "actual": "a" }) } else { Value::Null },
                "measurements": [{ "name": "period", "unit": "ns", "value": period }],
            }],
        });
        results::read(&text.to_string()).unwrap()
    }

    fn text_of(comparison: &Comparison) -> String {
        let mut text = Vec::new();
        comparison.write(Form::Text(Style::default()), &mut text).unwrap();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn what_a_release_changed() {
        let old = result("pass", "1.0", 100_000_000, "0000");
        let worse = compare(&old, &result("fail", "1.1", 120_000_000, "E803"), Missing::Worse);
        assert!(worse.has_regressions());
        let kinds: Vec<_> = worse.changes.iter().map(|change| (&*change.kind, change.direction)).collect();
        assert_eq!(kinds[0], ("verdict", Direction::Worse));
        assert_eq!(kinds.len(), 4);
        let text = text_of(&worse);
        assert!(text.contains("pass -> fail") && text.contains("1017h:00: 0000 -> E803"));
        let better = compare(&result("fail", "1.0", 100_000_000, "0000"), &old, Missing::Worse);
        assert!(!better.has_regressions() && better.changes[0].direction == Direction::Better);
        assert!(text_of(&compare(&old, &old, Missing::Worse)).ends_with("no difference\n"));
        assert!(
            compare(&old, &result("pass", "1.0", 100_500_000, "0000"), Missing::Worse).changes.is_empty(),
            "jitter"
        );
    }

    /// A failure that a waiver excuses in the new release is not called better; one that the manual excuses is.
    #[test]
    fn what_is_waived_is_not_mended() {
        let old = result("fail", "1.0", 1, "00");
        let mut waived = result("deviation", "1.0", 1, "00");
        waived.cases[0].waiver_line = Some(3);
        waived.cases[0].documented = Some("waived: ticket 4711".to_owned());
        let compared = compare(&old, &waived, Missing::Worse);
        assert_eq!(compared.changes[0].direction, Direction::Waived);
        let text = text_of(&compared);
        assert!(text.contains("Waived since") || text.contains("waived"), "{text}");
        assert!(text.contains("waived: ticket 4711") && !text.contains("better"), "{text}");
        assert_eq!(
            compare(&old, &result("deviation", "1.0", 1, "00"), Missing::Worse).changes[0].direction,
            Direction::Better
        );
        assert!(compare(&waived, &old, Missing::Worse).has_regressions(), "the waiver is gone");
    }

    #[test]
    fn a_case_that_no_longer_runs_got_worse() {
        let old = result("pass", "1.0", 1, "00");
        assert!(compare(&old, &result("not_applicable", "1.0", 1, "00"), Missing::Worse).has_regressions());
    }

    #[test]
    fn lost_coverage_got_worse_unless_it_is_meant() {
        let old = result("pass", "1.0", 1, "00");
        let (mut fewer, mut cancelled) = (old.clone(), old.clone());
        fewer.cases.clear();
        cancelled.cancelled = true;
        assert!(compare(&old, &fewer, Missing::Worse).has_regressions());
        assert!(!compare(&old, &fewer, Missing::Allowed).has_regressions());
        assert!(compare(&old, &cancelled, Missing::Allowed).has_regressions());
    }

    #[test]
    fn other_documents_are_refused() {
        let refused = |text: &str| results::read::<TestResult>(text).unwrap_err().to_string();
        assert!(refused("{}").contains("`canvass test --format json`: missing field `schema`"));
        assert!(refused(r#"{"schema":"canvass/test/2","device":{},"cases":[]}"#).contains("found canvass/test/2"));
        assert!(refused(r#"{"cases":7,"schema":"canvass/decode/1"}"#).contains("found canvass/decode/1"));
        let unknown = r#"{"schema":"canvass/test/1","device":{},"cases":[{"id":"a","verdict":"good","reason":null}]}"#;
        assert!(refused(unknown).contains("found \"good\""));
    }
}
