//! Selection of cases: `--select`, `--exclude`, `--failed-from`, `--shard`.

use crate::output::diagnostic;
use crate::status::Failure;
use anyhow::{Context, anyhow};
use canvass_reports::results::{self, TestResult};
use canvass_suite::case::Case;
use canvass_suite::catalogue::{Selector, cases, find, meant, select, shuffled};
use canvass_traces::small_file::{self, OF_PROGRAM};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Options that select cases.
#[derive(clap::Args)]
pub struct CaseChoice {
    /// Cases to run: the beginning of an id (301/sdo), a pattern (301/*/toggle) or a section (7.2.8)
    #[arg(long, value_name = "SELECTOR", value_delimiter = ',')]
    select: Vec<Selector>,
    /// Cases to leave out; written as for --select
    #[arg(long, value_name = "SELECTOR", value_delimiter = ',')]
    exclude: Vec<Selector>,
    /// Run only the cases that failed or could not be judged in this result of `canvass test --format json`
    #[arg(long, value_name = "FILE")]
    failed_from: Option<PathBuf>,
    /// Run only this part of the cases, such as 2/5, to divide them among several runs
    #[arg(long, value_name = "N/M")]
    shard: Option<Shard>,
    /// Run the cases in a random order of this seed: the verdicts must be the same (cases that can lose the device stay
    /// last)
    #[arg(long, value_name = "SEED", conflicts_with_all = ["span", "profile"])]
    pub shuffle: Option<u64>,
}

/// A part of all cases, which are divided into `of` parts.
#[derive(Clone, Copy, Debug)]
struct Shard {
    /// Number of the part, from 1.
    number: usize,
    of: usize,
}

impl FromStr for Shard {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> anyhow::Result<Self> {
        let parts = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        let shard = parts.filter(|&(number, of)| (1..=of).contains(&number)).map(|(number, of)| Self { number, of });
        shard.ok_or_else(|| anyhow!("expected N/M with N from 1 to M, such as 2/5, found \"{text}\""))
    }
}

impl CaseChoice {
    /// The selected cases in the order in which they run, at least one.
    ///
    /// # Errors
    /// If a selector matches no case, or no case is left: a run without cases must not look like a success.
    pub fn cases(&self) -> Result<Vec<&'static Case>, Failure> {
        let mut chosen = select(&self.select).map_err(|idle| selects_nothing("--select", &idle))?;
        for selector in &self.exclude {
            if !cases().into_iter().any(|case| selector.selects(case)) {
                return Err(selects_nothing("--exclude", selector));
            }
        }
        chosen.retain(|case| !self.exclude.iter().any(|selector| selector.selects(case)));
        if let Some(path) = &self.failed_from {
            let failed = failed_in(path)?;
            chosen.retain(|case| failed.contains(&case.id));
        }
        if let Some(Shard { number, of }) = self.shard {
            // Parts take every Nth case, so that slow cases of one family are spread over all parts.
            chosen = chosen.into_iter().skip(number - 1).step_by(of).collect();
        }
        if chosen.is_empty() {
            return Err(Failure::unreachable(anyhow!("no case was executed: {} leaves none", self.what_leaves_none())));
        }
        Ok(match self.shuffle {
            Some(seed) => shuffled(&chosen, seed),
            None => chosen,
        })
    }

    fn what_leaves_none(&self) -> &'static str {
        match (&self.failed_from, self.shard) {
            (_, Some(_)) => "--shard",
            (Some(_), None) => "--failed-from",
            (None, None) => "--exclude",
        }
    }

    /// The result that `--failed-from` names.
    pub fn result(&self) -> Option<&Path> {
        self.failed_from.as_deref()
    }
}

fn selects_nothing(option: &str, selector: &Selector) -> Failure {
    let meant = meant(selector);
    Failure::unreachable(anyhow!(
        "no case was executed: {option} {selector} selects none{meant}, see `canvass list cases`"
    ))
}

fn failed_in(path: &Path) -> Result<Vec<&'static str>, Failure> {
    let text = small_file::read_text(path, OF_PROGRAM).with_context(|| format!("can't read {}", path.display()))?;
    let result: TestResult = results::read(&text).with_context(|| format!("{}", path.display()))?;
    let mut failed = Vec::new();
    for id in result.failed() {
        match find(id) {
            Some(case) => failed.push(case.id),
            None => diagnostic(&format!("canvass: {}: case {id} does not exist any more", path.display())),
        }
    }
    if failed.is_empty() {
        let path = path.display();
        return Err(Failure::unreachable(anyhow!(
            "no case was executed: {path} has no failed case that could run again"
        )));
    }
    if result.cancelled {
        diagnostic(&format!(
            "canvass: {} is of a cancelled run: the cases that it did not reach are not run now",
            path.display()
        ));
    }
    Ok(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards() {
        let shard = |text: &str| text.parse::<Shard>().map(|shard| (shard.number, shard.of)).ok();
        assert_eq!((shard("2/5"), shard("1/1")), (Some((2, 5)), Some((1, 1))));
        for wrong in ["0/5", "6/5", "2", "2/0", "a/b", "-1/5"] {
            assert_eq!(shard(wrong), None, "{wrong}");
        }
    }
}
