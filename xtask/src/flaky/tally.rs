//! Counts verdicts, and the changed verdicts among them.

use anyhow::{Context, Result};
use serde_json::Value;
use std::collections::BTreeMap;

/// The needs in a report that name a late machine, or a late device as a whole; see `docs/live.md`.
const LATE: [&str; 2] = ["the tester's machine keeps up", "the device keeps up"];

/// The verdicts of one run, by case.
pub struct Run {
    verdicts: BTreeMap<String, Verdict>,
}

struct Verdict {
    verdict: String,
    is_late: bool,
    reason: String,
}

impl Run {
    /// Reads the report of `canvass test --format json`.
    ///
    /// # Errors
    /// If it is no report.
    pub fn read(report: &[u8]) -> Result<Self> {
        let report: Value = serde_json::from_slice(report)?;
        let cases = report["cases"].as_array().context("a report without cases")?;
        let verdict = |case: &Value| {
            let id = case["id"].as_str()?.to_owned();
            let reason = &case["reason"];
            let is_late = case["verdict"] == "inconclusive" && LATE.iter().any(|duty| reason["duty"] == *duty);
            Some((id, Verdict { verdict: case["verdict"].as_str()?.to_owned(), is_late, reason: reason.to_string() }))
        };
        let verdicts = cases.iter().map(verdict).collect::<Option<_>>().context("a case without id or verdict")?;
        Ok(Self { verdicts })
    }
}

/// The expected verdicts.
pub struct Verdicts {
    /// The right verdicts of each case. A case has two if an idle machine can't decide over the transport what the
    /// simulated bus shows.
    verdicts: BTreeMap<String, Vec<String>>,
    /// Number of cases whose verdict differs between transport and simulated bus, on an idle machine.
    transport: usize,
}

impl Verdicts {
    /// The verdicts of the simulated bus; for cases that can't be decided over the transport, also the verdict of an
    /// idle machine. If the idle machine was late, only the verdict of the simulated bus counts.
    ///
    /// # Errors
    /// If the two runs have different cases.
    pub fn expected(simulated: &Run, quiet: &Run) -> Result<Self> {
        let mut expected = Self { verdicts: BTreeMap::new(), transport: 0 };
        for (id, truth) in &simulated.verdicts {
            let here = quiet.verdicts.get(id).with_context(|| format!("{id} did not run"))?;
            let is_undecided = !here.is_late && matches!(here.verdict.as_str(), "not_applicable" | "inconclusive");
            let mut right = vec![truth.verdict.clone()];
            if is_undecided && here.verdict != truth.verdict {
                eprintln!(
                    "{id}: {} over the transport, {} on the simulated bus: {}",
                    here.verdict, truth.verdict, here.reason
                );
                expected.transport += 1;
                right.push(here.verdict.clone());
            }
            expected.verdicts.insert(id.clone(), right);
        }
        Ok(expected)
    }
}

/// The totals of one model.
pub struct Tally {
    expected: Verdicts,
    runs: u32,
    same: u32,
    late: u32,
    changes: Vec<String>,
}

impl Tally {
    pub const HEADING: &str =
        "| model | runs | verdicts | the same | inconclusive: late | changed | undecided by the transport |";

    pub const fn new(expected: Verdicts) -> Self {
        Self { expected, runs: 0, same: 0, late: 0, changes: Vec::new() }
    }

    /// Counts the verdicts of a run.
    pub fn add(&mut self, run: &Run) {
        self.runs += 1;
        for (id, expected) in &self.expected.verdicts {
            match run.verdicts.get(id) {
                Some(found) if expected.contains(&found.verdict) => self.same += 1,
                Some(found) if found.is_late => self.late += 1,
                Some(found) => {
                    let expected = expected.join(" or ");
                    self.changes.push(format!("{id}: {expected} became {}: {}", found.verdict, found.reason))
                }
                None => self.changes.push(format!("{id}: {} became no verdict at all", expected.join(" or "))),
            }
        }
    }

    /// Number of verdicts that changed to another verdict than "inconclusive" for a late machine.
    pub const fn changed(&self) -> usize {
        self.changes.len()
    }

    /// Each change as text.
    pub fn changes(&self) -> &[String] {
        &self.changes
    }

    fn all(&self) -> usize {
        self.same as usize + self.late as usize + self.changes.len()
    }

    /// The percentage of verdicts lost to a late machine.
    pub fn late_share(&self) -> f64 {
        if self.all() == 0 { 0.0 } else { f64::from(self.late) * 100.0 / self.all() as f64 }
    }

    /// A row of the table.
    pub fn row(&self, model: &str) -> String {
        format!(
            "| `{model}` | {} | {} | {} | {} ({:.2} %) | {} | {} |",
            self.runs,
            self.all(),
            self.same,
            self.late,
            self.late_share(),
            self.changed(),
            self.expected.transport
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(cases: &[(&str, &str, &str)]) -> Run {
        let cases: Vec<String> = cases
            .iter()
            .map(|(id, verdict, duty)| {
                format!(r#"{{"id": "{id}", "verdict": "{verdict}", "reason": {{"duty": "{duty}"}}}}"#)
            })
            .collect();
        Run::read(format!(r#"{{"cases": [{}]}}"#, cases.join(",")).as_bytes()).unwrap()
    }

    #[test]
    fn only_a_late_machine_excuses() {
        let truth = run(&[("a", "pass", ""), ("b", "fail", "x"), ("c", "pass", "")]);
        let quiet = run(&[("a", "pass", ""), ("b", "inconclusive", LATE[0]), ("c", "not_applicable", "no bit rate")]);
        let mut tally = Tally::new(Verdicts::expected(&truth, &quiet).unwrap());
        tally.add(&run(&[("a", "inconclusive", LATE[1]), ("b", "fail", "x"), ("c", "not_applicable", "")]));
        tally.add(&run(&[("a", "inconclusive", "no answer"), ("b", "pass", ""), ("c", "not_applicable", "")]));
        assert_eq!((tally.same, tally.late, tally.changed()), (3, 1, 2));
        assert_eq!(tally.expected.transport, 1);
        assert!(tally.late_share() > 16.0);
        assert!(tally.changes()[0].starts_with("a: pass became inconclusive"), "{:?}", tally.changes());
    }

    #[test]
    fn a_case_that_did_not_run_has_changed() {
        let truth = run(&[("a", "pass", "")]);
        let mut tally = Tally::new(Verdicts::expected(&truth, &truth).unwrap());
        tally.add(&run(&[]));
        assert_eq!(tally.changed(), 1);
    }
}
