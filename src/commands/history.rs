//! `canvass history`: many results of `canvass test`.

use super::compare::{named, read, release as release_name};
use super::test::reports::{ReportFormat, Shown};
use crate::files::Files;
use crate::provenance::{Collected, Remarks, Subject, Typed};
use crate::status::{Failure, Status};
use anyhow::{Result, anyhow};
use canvass_reports::history::{History, Release};
use std::path::PathBuf;

/// Show many results of `canvass test --format json`, over releases and samples
///
/// For each case the history shows its verdict in every release, the release since which it fails, and whether it is
/// flaky; for each release it shows which cases ran. Give the results in the order of the releases, oldest first. The
/// release of a result is the name before it (1.4=a.json), otherwise its --note release=1.4, otherwise the name of its
/// file. Several results of one release are samples of it.
#[derive(clap::Args)]
pub struct Args {
    /// The results, oldest first
    #[arg(required = true, value_name = "[RELEASE=]FILE")]
    files: Vec<String>,
    #[command(flatten)]
    shown: Shown,
    #[command(flatten)]
    remarks: Remarks,
}

impl Args {
    pub fn run(self, typed: &Typed) -> Result<Status, Failure> {
        if self.shown.formats().any(|format| matches!(format, ReportFormat::Junit | ReportFormat::Sarif)) {
            return Err(anyhow!(
                "a history has no pass or fail, which JUnit and SARIF need: choose table, json, html or markdown (`canvass \
                 compare` has junit)"
            )
            .into());
        }
        let named: Vec<(Option<&str>, PathBuf)> = self.files.iter().map(|file| named(file)).collect();
        let paths = named.iter().map(|(_, path)| path);
        Files::new().reads(paths).writes(self.shown.files())?;
        let mut provenance = Collected::begin(&self.remarks, typed, Subject::Files)?;
        let mut releases: Vec<Release> = Vec::new();
        for (release, path) in &named {
            let result = read(path)?;
            provenance.file("result", path);
            let name = release_name(*release, &result, path);
            match releases.iter_mut().find(|known| known.name == name) {
                Some(known) => known.results.push(result),
                None => releases.push(Release { name, results: vec![result] }),
            }
        }
        let mut history = History::of(&releases);
        history.provenance = provenance.0;
        self.shown.write(&history)?;
        Ok(Status::Good)
    }
}
