//! Two results of `canvass test --format json`: what changed from one release of a firmware to the next.
//!
//! Only the members of the contract `canvass/test/1` that are compared are read. A document of another version is refused:
//! its verdicts may mean something else.

pub mod html;
pub mod junit;
pub mod markdown;

use crate::escape::printable;
use crate::provenance::{self, Provenance};
use canvass_suite::runner::DeviceIdentity;
use canvass_suite::verdict::Kind;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The name and version of the contract of [`Comparison::json`].
pub const SCHEMA: &str = "canvass/compare/1";

/// A measured time that changes by less than this share is as before, in percent.
pub const NOTICEABLE_PERCENT: u64 = 10;

/// A measured time that changes by less is as before, whatever the share: timers and buses jitter.
const NOTICEABLE_NS: u64 = 1_000_000;

/// A result, as far as it is compared.
#[derive(Clone, Debug, Deserialize)]
pub struct TestResult {
    schema: String,
    /// The user ended the run before all cases had run.
    #[serde(default)]
    cancelled: bool,
    device: BTreeMap<String, Value>,
    #[serde(default)]
    dictionary: Vec<Object>,
    #[serde(default)]
    provenance: Value,
    cases: Vec<Case>,
}

#[derive(Clone, PartialEq, Eq, Debug, Deserialize)]
struct Object {
    index: u16,
    sub: u8,
    data: String,
}

#[derive(Clone, Debug, Deserialize)]
struct Case {
    id: String,
    #[serde(deserialize_with = "verdict")]
    verdict: Kind,
    reason: Option<Reason>,
    #[serde(default)]
    measurements: Vec<Measurement>,
    #[serde(default)]
    flaky: bool,
    quarantine: Option<Quarantined>,
    #[serde(default)]
    duration_ns: Option<u64>,
}

/// A case of a result, as far as a history needs it.
#[derive(Clone, Debug)]
pub(crate) struct Sample {
    pub verdict: Kind,
    pub is_flaky: bool,
    /// In nanoseconds.
    pub duration: Option<u64>,
    /// What was measured, in nanoseconds.
    pub times: Vec<(String, u64)>,
}

fn verdict<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Kind, D::Error> {
    let name = String::deserialize(deserializer)?;
    let expected = || serde::de::Error::custom(format!("expected a verdict, found \"{}\"", printable(&name)));
    Kind::by_name(&name).ok_or_else(expected)
}

#[derive(Clone, Debug, Deserialize)]
struct Quarantined {
    until: String,
    owner: String,
}

#[derive(Clone, Debug, Deserialize)]
struct Reason {
    duty: String,
    expected: String,
    actual: String,
}

#[derive(Clone, Debug, Deserialize)]
struct Measurement {
    name: String,
    unit: String,
    value: u64,
}

/// What can't be compared.
#[derive(Debug, thiserror::Error)]
pub enum NotAResult {
    /// No JSON, or not with the members of a result.
    #[error("expected a result of `canvass test --format json`: {0}")]
    Unreadable(#[from] serde_json::Error),
    /// Another document, or a later version whose verdicts may mean something else.
    #[error("expected a document of schema canvass/test/1, found {0}")]
    Schema(String),
}

/// Which way something changed.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Direction {
    /// It was better before.
    Worse,
    /// It is better now.
    Better,
    /// Neither.
    Other,
}

impl Direction {
    /// All, the worst first.
    pub const ALL: [Self; 3] = [Self::Worse, Self::Better, Self::Other];

    const fn title(self) -> &'static str {
        match self {
            Self::Worse => "Worse",
            Self::Better => "Better",
            Self::Other => "Other changes",
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Worse => "worse",
            Self::Better => "better",
            Self::Other => "other",
        }
    }
}

/// One difference. Texts come from the device or a file: they may hold anything.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ResultChange {
    /// Verdict, timing, identity or dictionary.
    pub kind: &'static str,
    /// The case, measurement or object.
    pub subject: String,
    /// What it was; `None`: it was not there.
    pub old: Option<String>,
    /// What it is; `None`: it is gone.
    pub new: Option<String>,
    /// Which way.
    pub direction: Direction,
    /// Why a case no longer passes.
    pub reason: Option<String>,
    /// Of a case that got worse: the earlier release in which it was bad last. It had been fixed since.
    pub returned: Option<String>,
}

/// All differences, the worst first.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Comparison {
    /// Regressions first, then improvements, then the rest.
    pub changes: Vec<ResultChange>,
    /// Where it comes from.
    pub provenance: Provenance,
}

impl ResultChange {
    /// What it was and what it is, for people.
    fn values(&self) -> (&str, &str) {
        (self.old.as_deref().unwrap_or("-"), self.new.as_deref().unwrap_or("-"))
    }

    /// Whether it is a case that is bad now and was not.
    fn is_regression(&self) -> bool {
        self.kind == "verdict" && self.direction == Direction::Worse && self.new.is_some()
    }

    /// Why, for people; first of all that it had been fixed.
    fn why(&self) -> Option<String> {
        let returned = self.returned.as_ref().map(|release| format!("again: it was bad in {release}"));
        let parts: Vec<String> = returned.into_iter().chain(self.reason.clone()).collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}

impl TestResult {
    /// Reads a result.
    ///
    /// # Errors
    /// [`NotAResult`].
    pub fn read(text: &str) -> Result<Self, NotAResult> {
        let result: Self = serde_json::from_str(text)?;
        match result.schema == crate::conformance::json::SCHEMA {
            true => Ok(result),
            false => Err(NotAResult::Schema(printable(&result.schema).into_owned())),
        }
    }

    /// The cases that failed, or about which nothing is known.
    pub fn failed(&self) -> impl Iterator<Item = &str> {
        let failed = self.cases.iter().filter(|case| case.verdict.badness() >= Kind::Inconclusive.badness());
        failed.map(|case| case.id.as_str())
    }

    /// The cases with their verdicts.
    pub fn verdicts(&self) -> impl Iterator<Item = (&str, Kind)> {
        self.cases.iter().map(|case| (case.id.as_str(), case.verdict))
    }

    /// A case, if it ran.
    pub(crate) fn sample(&self, id: &str) -> Option<Sample> {
        let case = self.cases.iter().find(|case| case.id == id)?;
        let times = case.measurements.iter().filter(|measurement| measurement.unit == "ns");
        Some(Sample {
            verdict: case.verdict,
            is_flaky: case.flaky,
            duration: case.duration_ns,
            times: times.map(|measurement| (measurement.name.clone(), measurement.value)).collect(),
        })
    }

    /// What the user noted of the run by that name.
    pub fn note(&self, name: &str) -> Option<&str> {
        self.provenance.get("notes")?.get(name)?.as_str()
    }

    /// Whether the user ended the run before all cases had run.
    pub const fn is_cancelled(&self) -> bool {
        self.cancelled
    }

    /// What the device said of itself.
    pub fn identity(&self) -> DeviceIdentity {
        let number = |name: &str| self.device.get(name).and_then(Value::as_u64).and_then(|n| u32::try_from(n).ok());
        let text = |name: &str| self.device.get(name).and_then(Value::as_str).map(str::to_owned);
        DeviceIdentity {
            device_type: number("device_type"),
            identity: ["vendor_id", "product_code", "revision_number", "serial_number"].map(number),
            names: ["name", "hardware_version", "software_version"].map(text),
        }
    }
}

/// What to make of cases that only the old result has.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Missing {
    /// What is no longer tested got worse.
    #[default]
    Worse,
    /// It was left out on purpose.
    Allowed,
}

/// Compares two results. Where they come from is for who has read them to say.
pub fn compare(old: &TestResult, new: &TestResult, missing: Missing) -> Comparison {
    let mut changes = verdicts(old, new, missing);
    changes.extend(new.cancelled.then(cancelled));
    changes.extend(timings(old, new));
    changes.extend(identity(old, new));
    changes.extend(dictionary(old, new));
    changes.sort_by_key(|change| change.direction);
    Comparison { changes, provenance: Provenance::default() }
}

/// A run that did not come to its end says nothing of what it left out.
fn cancelled() -> ResultChange {
    ResultChange {
        kind: "run",
        subject: "the new run".to_owned(),
        old: None,
        new: Some("cancelled".to_owned()),
        direction: Direction::Worse,
        reason: None,
        returned: None,
    }
}

fn verdicts(old: &TestResult, new: &TestResult, missing: Missing) -> Vec<ResultChange> {
    let by_id = |result: &TestResult| -> BTreeMap<String, Case> {
        result.cases.iter().map(|case| (case.id.clone(), case.clone())).collect()
    };
    pairs(&by_id(old), &by_id(new), |id, old, new| {
        let direction = match (old, new) {
            (Some(old), Some(new)) if old.verdict == new.verdict => return None,
            // It is shown, and does not count yet.
            (_, Some(Case { quarantine: Some(_), .. })) => Direction::Other,
            (Some(old), Some(new)) => match new.verdict.badness().cmp(&old.verdict.badness()) {
                std::cmp::Ordering::Greater => Direction::Worse,
                std::cmp::Ordering::Less => Direction::Better,
                std::cmp::Ordering::Equal => Direction::Other,
            },
            // A case that is new fails for the first time, or says nothing of what was before.
            (None, Some(new)) if new.verdict.badness() >= Kind::Inconclusive.badness() => Direction::Worse,
            (Some(old), None) if old.verdict.is_executed() && missing == Missing::Worse => Direction::Worse,
            _ => Direction::Other,
        };
        let reason = new.and_then(why);
        let verdict = |case: Option<&Case>| case.map(|case| case.verdict.name().to_owned());
        Some(ResultChange {
            kind: "verdict",
            subject: id.to_owned(),
            old: verdict(old),
            new: verdict(new),
            direction,
            reason,
            returned: None,
        })
    })
}

/// Why a case is not good, and until when that does not count.
fn why(case: &Case) -> Option<String> {
    let Reason { duty, expected, actual } = case.reason.as_ref()?;
    let quarantine = case.quarantine.as_ref();
    let quarantine = quarantine.map(|Quarantined { until, owner }| format!("in quarantine until {until} ({owner}); "));
    Some(format!("{}{duty}: expected {expected}, found {actual}", quarantine.unwrap_or_default()))
}

fn timings(old: &TestResult, new: &TestResult) -> Vec<ResultChange> {
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
        let shown = |m: &Measurement| if is_time { milliseconds(m.value) } else { m.value.to_string() };
        is_noticeable.then(|| ResultChange {
            kind: "timing",
            subject: name.to_owned(),
            old: Some(shown(old)),
            new: Some(shown(new)),
            // A longer or shorter time is wrong only where a case says so, and then its verdict changes.
            direction: Direction::Other,
            reason: None,
            returned: None,
        })
    })
}

fn milliseconds(nanos: u64) -> String {
    format!("{}.{:03} ms", nanos / 1_000_000, nanos / 1_000 % 1_000)
}

fn identity(old: &TestResult, new: &TestResult) -> Vec<ResultChange> {
    pairs(&old.device, &new.device, |name, old, new| difference("identity", name, old, new, Value::to_string))
}

fn dictionary(old: &TestResult, new: &TestResult) -> Vec<ResultChange> {
    let by_address = |result: &TestResult| -> BTreeMap<String, String> {
        let row = |object: &Object| (format!("{:04X}h:{:02X}", object.index, object.sub), object.data.clone());
        result.dictionary.iter().map(row).collect()
    };
    pairs(&by_address(old), &by_address(new), |at, old, new| difference("dictionary", at, old, new, String::clone))
}

fn difference<T: PartialEq>(
    kind: &'static str,
    subject: &str,
    old: Option<&T>,
    new: Option<&T>,
    shown: impl Fn(&T) -> String,
) -> Option<ResultChange> {
    (old != new).then(|| ResultChange {
        kind,
        subject: subject.to_owned(),
        old: old.map(&shown),
        new: new.map(&shown),
        direction: Direction::Other,
        reason: None,
        returned: None,
    })
}

/// Every key of one of the maps, with what each has for it.
fn pairs<T>(
    old: &BTreeMap<String, T>,
    new: &BTreeMap<String, T>,
    compare: impl Fn(&str, Option<&T>, Option<&T>) -> Option<ResultChange>,
) -> Vec<ResultChange> {
    let gone = old.keys().filter(|key| !new.contains_key(*key));
    let keys = new.keys().chain(gone);
    keys.filter_map(|key| compare(key, old.get(key), new.get(key))).collect()
}

impl Comparison {
    /// Whether something got worse.
    pub fn has_regressions(&self) -> bool {
        self.changes.iter().any(|change| change.direction == Direction::Worse)
    }

    fn of(&self, direction: Direction) -> impl Iterator<Item = &ResultChange> {
        self.changes.iter().filter(move |change| change.direction == direction)
    }

    /// Tells regressions that return from new ones, by the releases before the two, oldest first.
    pub fn recall(&mut self, earlier: &[(String, TestResult)]) {
        let was_bad = |(_, result): &&(String, TestResult), id: &str| result.failed().any(|failed| failed == id);
        for change in self.changes.iter_mut().filter(|change| change.is_regression()) {
            let last = earlier.iter().rev().find(|release| was_bad(release, &change.subject));
            change.returned = last.map(|(release, _)| release.clone());
        }
    }

    /// One line about the outcome.
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

    /// The differences as JSON, `"schema": "canvass/compare/1"`.
    pub fn json(&self) -> String {
        let row = |change: &ResultChange| {
            json!({
                "kind": change.kind,
                "subject": change.subject,
                "old": change.old,
                "new": change.new,
                "direction": change.direction.name(),
                "reason": change.reason,
                "returned": change.returned,
            })
        };
        let count = |direction| self.of(direction).count();
        let document = json!({
            "schema": SCHEMA,
            "provenance": provenance::json(&self.provenance),
            "summary": {
                "worse": count(Direction::Worse),
                "better": count(Direction::Better),
                "other": count(Direction::Other),
            },
            "changes": self.changes.iter().map(row).collect::<Vec<_>>(),
        });
        crate::escape::json(&format!("{document:#}\n")).to_string()
    }

    /// The differences for people.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for change in &self.changes {
            let (old, new) = change.values();
            let (subject, old, new) = (printable(&change.subject), printable(old), printable(new));
            // Writing to a string can't fail.
            let _ = writeln!(text, "{:6} {:10} {subject}: {old} -> {new}", change.direction.name(), change.kind);
            if let Some(reason) = change.why() {
                let _ = writeln!(text, "                  {}", printable(&reason));
            }
        }
        let _ = writeln!(text, "{}", self.outcome());
        let _ = writeln!(text);
        for line in provenance::short_text(&self.provenance) {
            let _ = writeln!(text, "{line}");
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canvass_analyzer::object;

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
        TestResult::read(&text.to_string()).unwrap()
    }

    #[test]
    fn what_a_release_changed() {
        let old = result("pass", "1.0", 100_000_000, "0000");
        let worse = compare(&old, &result("fail", "1.1", 120_000_000, "E803"), Missing::Worse);
        assert!(worse.has_regressions());
        let kinds: Vec<_> = worse.changes.iter().map(|change| (change.kind, change.direction)).collect();
        assert_eq!(kinds[0], ("verdict", Direction::Worse));
        assert_eq!(kinds.len(), 4);
        assert!(worse.text().contains("pass -> fail") && worse.text().contains("1017h:00: 0000 -> E803"));
        let better = compare(&result("fail", "1.0", 100_000_000, "0000"), &old, Missing::Worse);
        assert!(!better.has_regressions() && better.changes[0].direction == Direction::Better);
        assert!(compare(&old, &old, Missing::Worse).text().starts_with("no difference\n"));
        assert!(
            compare(&old, &result("pass", "1.0", 100_500_000, "0000"), Missing::Worse).changes.is_empty(),
            "jitter"
        );
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
        assert!(TestResult::read("{}").is_err());
        let later = r#"{"schema":"canvass/test/2","device":{},"cases":[]}"#;
        assert!(TestResult::read(later).is_err());
        let unknown = r#"{"schema":"canvass/test/1","device":{},"cases":[{"id":"a","verdict":"good","reason":null}]}"#;
        assert!(TestResult::read(unknown).unwrap_err().to_string().contains("found \"good\""));
        let other = r#"{"schema":"canvass/decode/1","device":{},"cases":[]}"#;
        assert!(TestResult::read(other).unwrap_err().to_string().contains("canvass/decode/1"));
    }
}
