//! `canvass compare`: what changed between two results of `canvass test`.

use crate::output::print;
use crate::status::{Failure, Status};
use anyhow::Context;
use canvass_reports::comparison::{Missing, TestResult, compare};
use std::path::{Path, PathBuf};

/// Compare two results of `canvass test --format json`
///
/// Says what a release of a firmware changed: verdicts, measured times, identity and object dictionary. Ends with status
/// 1 if a verdict got worse, if a case that was judged before is missing, or if the new run was cancelled.
#[derive(clap::Args)]
pub struct Args {
    /// The result of the release before
    old: PathBuf,
    /// The result of the new release
    new: PathBuf,
    /// Cases that only the old result has were left out on purpose
    #[arg(long)]
    allow_missing: bool,
    /// How to print the differences
    #[arg(long, value_enum, default_value_t)]
    format: ComparisonFormat,
}

#[derive(Clone, Copy, Default, clap::ValueEnum)]
enum ComparisonFormat {
    /// Text
    #[default]
    Table,
    /// The contract for programs
    Json,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let missing = if self.allow_missing { Missing::Allowed } else { Missing::Worse };
        let comparison = compare(&read(&self.old)?, &read(&self.new)?, missing);
        match self.format {
            ComparisonFormat::Table => print(&comparison.text())?,
            ComparisonFormat::Json => print(&comparison.json())?,
        }
        Ok(if comparison.has_regressions() { Status::Findings } else { Status::Good })
    }
}

fn read(path: &Path) -> anyhow::Result<TestResult> {
    let text = std::fs::read_to_string(path).with_context(|| format!("can't read {}", path.display()))?;
    TestResult::read(&text).with_context(|| format!("{}", path.display()))
}
