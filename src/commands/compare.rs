//! `canvass compare`: what changed between two results of `canvass test`.

use super::test::reports::Shown;
use crate::files::Files;
use crate::provenance::{Collected, Remarks, Subject, Typed};
use crate::status::{Failure, Status};
use anyhow::Context;
use canvass_reports::comparison::{Missing, compare};
use canvass_reports::results::{self, TestResult};
use canvass_traces::small_file::{self, OF_PROGRAM};
use std::path::{Path, PathBuf};

/// Compare two results of `canvass test --format json`
///
/// Shows the changes in a firmware release: verdicts, measured times, identity and object dictionary. Ends with status
/// 1 if a verdict got worse, if a case that was judged before is missing, or if the new run was cancelled.
#[derive(clap::Args)]
pub struct Args {
    /// The result of the release before
    old: PathBuf,
    /// The result of the new release
    new: PathBuf,
    /// Accept cases that only the old result has, because they were left out on purpose
    #[arg(long)]
    allow_missing: bool,
    /// Results of releases before OLD, oldest first. A case that is bad in NEW and was bad in one of them, but not in
    /// OLD, is reported as returned
    #[arg(long, value_name = "[RELEASE=]FILE")]
    earlier: Vec<String>,
    #[command(flatten)]
    shown: Shown,
    #[command(flatten)]
    remarks: Remarks,
}

impl Args {
    pub fn run(self, typed: &Typed) -> Result<Status, Failure> {
        let missing = if self.allow_missing { Missing::Allowed } else { Missing::Worse };
        let earlier: Vec<_> = self.earlier.iter().map(|file| named(file)).collect();
        let paths = earlier.iter().map(|(_, path)| path).chain([&self.old, &self.new]);
        Files::new().reads(paths).writes(self.shown.files())?;
        let (old, new) = (read(&self.old)?, read(&self.new)?);
        let mut provenance = Collected::begin(&self.remarks, typed, Subject::Files)?;
        for (role, path, result) in [("old", &self.old, &old), ("new", &self.new, &new)] {
            provenance.file(role, path);
            provenance.device(&format!("{role} device"), result.identity());
        }
        let mut comparison = compare(&old, &new, missing);
        let earlier = earlier.into_iter().map(|(name, path)| {
            provenance.file("earlier", &path);
            read(&path).map(|result| (release(name, &result, &path), result))
        });
        comparison.recall(&earlier.collect::<anyhow::Result<Vec<_>>>()?);
        comparison.releases = [release(None, &old, &self.old), release(None, &new, &self.new)];
        comparison.provenance = provenance.0;
        self.shown.write(&comparison)?;
        Ok(if comparison.has_regressions() { Status::Findings } else { Status::Good })
    }
}

/// Splits `RELEASE=FILE`; a plain `FILE` names no release.
pub fn named(text: &str) -> (Option<&str>, PathBuf) {
    match text.split_once('=') {
        Some((release, file)) if !release.is_empty() && !Path::new(text).exists() => (Some(release), file.into()),
        _ => (None, text.into()),
    }
}

/// The name of a release: as the user typed it, else as the result notes it, else the name of the file.
pub fn release(typed: Option<&str>, result: &TestResult, path: &Path) -> String {
    let stem = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    typed.or(result.note("release")).map_or_else(stem, str::to_owned)
}

/// Reads a result of `canvass test`.
pub fn read(path: &Path) -> anyhow::Result<TestResult> {
    let text = small_file::read_text(path, OF_PROGRAM).with_context(|| format!("can't read {}", path.display()))?;
    results::read(&text).with_context(|| format!("{}", path.display()))
}
