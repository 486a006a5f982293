//! Many results of `canvass test`: the verdict of each case in each release, since when it is bad, and whether it is
//! flaky.
//!
//! Results of the same release are its samples. The verdict of a case is the worst of the samples, and the case is
//! flaky if they differ.

mod json;
mod report;

use crate::conformance::is_bad;
use crate::provenance::Provenance;
use crate::results::history::{self, Cell};
use crate::results::{TestResult, Verdict};
use canvass_suite::verdict::Kind;

/// A release with its results, in the order in which they were given.
#[derive(Clone, Debug)]
pub struct Release {
    /// The name of the release.
    pub name: String,
    /// The results of the release, one for each sample.
    pub results: Vec<TestResult>,
}

/// The evaluation of all results. Names come from users and devices and may contain any characters.
#[derive(Clone, Debug, Default)]
pub struct History {
    /// The releases, oldest first.
    pub releases: Vec<history::Release>,
    /// The cases, sorted by id.
    pub cases: Vec<ReleaseRow>,
    /// The provenance of the history.
    pub provenance: Provenance,
}

/// The verdicts of a case over the releases.
#[derive(Clone, Debug)]
pub struct ReleaseRow {
    /// The id of the case.
    pub id: String,
    /// The verdict of the case in each release.
    pub cells: Vec<Cell>,
}

/// The changes in the verdict of a case over the releases.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Course {
    /// The first release in which the case was bad.
    pub first_bad: Option<usize>,
    /// The releases in which the case became bad: it is bad there, and was good or missing in the release before.
    pub became_bad: Vec<usize>,
    /// The releases among [`became_bad`](Self::became_bad) in which the case was bad again after it had been good.
    pub returned: Vec<usize>,
    /// The releases in which the case became good again.
    pub became_good: Vec<usize>,
    /// The first release in which the case ran, if that is not the first of all.
    pub new_in: Option<usize>,
    /// The release from which on the case did not run any more.
    pub gone_in: Option<usize>,
}

impl History {
    /// The history of these releases, oldest first. The caller, who has read them, adds the provenance.
    pub fn of(releases: &[Release]) -> Self {
        let ids = releases.iter().flat_map(|release| &release.results).flat_map(TestResult::verdicts);
        let mut ids: Vec<&str> = ids.map(|(id, _)| id).collect();
        ids.sort_unstable();
        ids.dedup();
        let row = |id: &str| ReleaseRow {
            id: id.to_owned(),
            cells: releases.iter().map(|release| Cell::of(id, &release.results)).collect(),
        };
        let cases = ids.into_iter().map(row).collect();
        Self { releases: releases.iter().map(column).collect(), cases, provenance: Provenance::default() }
    }

    fn name(&self, release: usize) -> &str {
        self.releases.get(release).map_or("", |column| &column.name)
    }

    /// The rows of cases that were bad, flaky, new or removed.
    pub fn telling(&self) -> impl Iterator<Item = (&ReleaseRow, Course)> {
        let told = |(row, course): &(&ReleaseRow, Course)| *course != Course::default() || row.is_flaky();
        self.cases.iter().map(|row| (row, row.course())).filter(told)
    }

    /// The whole history in one line.
    fn outcome(&self) -> String {
        let last = self.releases.len().saturating_sub(1);
        let bad = self.cases.iter().filter(|row| row.verdict(last).is_some_and(is_bad)).count();
        let newly = self.telling().filter(|(_, course)| course.became_bad.last() == Some(&last)).count();
        let returned = self.telling().filter(|(_, course)| course.returned.last() == Some(&last)).count();
        let returned = if returned > 0 { format!(" ({returned} again)") } else { String::new() };
        let flaky = self.cases.iter().filter(|row| row.is_flaky()).count();
        let (cases, releases) = (self.cases.len(), self.releases.len());
        format!(
            "{cases} cases over {releases} releases; in the last one {bad} are bad, {newly} of them since it{returned}; {flaky} are flaky"
        )
    }
}

fn column(release: &Release) -> history::Release {
    let mut software: Vec<String> =
        release.results.iter().filter_map(|result| result.device.software_version.clone()).collect();
    software.sort_unstable();
    software.dedup();
    history::Release {
        cancelled: release.results.iter().any(|result| result.cancelled),
        name: release.name.clone(),
        samples: release.results.len(),
        software,
    }
}

impl Cell {
    fn of(id: &str, samples: &[TestResult]) -> Self {
        let mut cell = Self::default();
        for case in samples.iter().filter_map(|result| result.cases.iter().find(|case| case.id == id)) {
            let verdict = case.verdict;
            let worse = cell.verdict.is_none_or(|known| verdict.0.badness() > known.0.badness());
            cell.flaky |= case.flaky || cell.verdict.is_some_and(|known| known != verdict);
            cell.verdict = if worse { Some(verdict) } else { cell.verdict };
            cell.duration_ns = cell.duration_ns.max(Some(case.duration_ns));
            for measured in case.measurements.iter().filter(|measured| measured.unit == "ns") {
                let longest = cell.times_ns.entry(measured.name.clone()).or_default();
                *longest = measured.value.max(*longest);
            }
        }
        cell
    }

    /// The verdict, if the case ran.
    fn kind(&self) -> Option<Kind> {
        self.verdict.map(|Verdict(kind)| kind)
    }
}

impl ReleaseRow {
    fn verdict(&self, release: usize) -> Option<Kind> {
        self.cells.get(release).and_then(Cell::kind)
    }

    /// Whether the case ended differently in samples of one release.
    pub fn is_flaky(&self) -> bool {
        self.cells.iter().any(|cell| cell.flaky)
    }

    /// How the verdict of the case changed over the releases.
    pub fn course(&self) -> Course {
        let verdicts: Vec<Option<Kind>> = self.cells.iter().map(Cell::kind).collect();
        let bad: Vec<bool> = verdicts.iter().map(|verdict| verdict.is_some_and(is_bad)).collect();
        let ran = |verdict: &Option<Kind>| verdict.is_some();
        let turned = |to: bool| -> Vec<usize> {
            let is_turn = |&at: &usize| bad[at] == to && (at > 0 && bad[at - 1] != to || at == 0 && to);
            (0..bad.len()).filter(is_turn).filter(|&at| verdicts[at].is_some()).collect()
        };
        let last = verdicts.iter().rposition(ran);
        let became_bad = turned(true);
        // A case that did not run in a release was not fixed by it.
        let was_good = |from: usize, to: usize| (from..to).any(|at| verdicts[at].is_some() && !bad[at]);
        let is_return = |pair: &[usize]| matches!(pair, [before, at] if was_good(*before, *at));
        let returned = became_bad.windows(2).filter(|pair| is_return(pair)).map(|pair| pair[1]).collect();
        Course {
            first_bad: bad.iter().position(|bad| *bad),
            became_bad,
            returned,
            became_good: turned(false),
            new_in: verdicts.iter().position(ran).filter(|at| *at > 0),
            gone_in: last.map(|at| at + 1).filter(|at| *at < verdicts.len()),
        }
    }
}

impl Course {
    /// The changes in words: `bad since 1.2, good again in 1.4`.
    fn told(&self, history: &History) -> String {
        let bad = |at: &usize| (*at, if self.returned.contains(at) { "bad again since" } else { "bad since" });
        let mut turns: Vec<(usize, &str)> = self.became_bad.iter().map(bad).collect();
        turns.extend(self.became_good.iter().map(|at| (*at, "good again in")));
        turns.extend(self.new_in.map(|at| (at, "new in")));
        turns.extend(self.gone_in.map(|at| (at, "no longer run in")));
        turns.sort_by_key(|turn| turn.0);
        let told = turns.into_iter().map(|(at, what)| format!("{what} {}", history.name(at)));
        told.collect::<Vec<_>>().join(", ")
    }
}

/// A sign for a verdict. It is a blank if the case did not run.
const fn sign(verdict: Option<Kind>) -> &'static str {
    match verdict {
        Some(kind) => crate::conformance::symbol(kind),
        None => "·",
    }
}

#[cfg(test)]
mod tests;
