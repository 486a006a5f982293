//! `canvass-fleet ingest`: captures and results into a lake.

use crate::cli::Engine;
use crate::output::{diagnostic, print, progress};
use crate::status::{Failure, Status};
use canvass_fleet::lake::{Ingest, Progress, Summary};

/// Put captures and results into a lake: Parquet by table and date
///
/// Files that are already in the lake are skipped; changed files are replaced. If a run was stopped, the next run
/// continues it.
#[derive(clap::Args)]
pub struct Args {
    /// Files, folders and patterns, here or as s3://BUCKET/...
    #[arg(required = true, value_name = "SOURCE")]
    source: Vec<String>,
    /// The lake: a folder, or s3://BUCKET/PREFIX
    #[arg(long, value_name = "LAKE")]
    into: String,
    /// Also hash files whose length and time have not changed
    #[arg(long)]
    rehash: bool,
    #[command(flatten)]
    engine: Engine,
}

/// Maximum number of broken files that are reported one by one.
const TOLD: usize = 20;

impl Args {
    pub async fn run(self) -> Result<Status, Failure> {
        let session = self.engine.session().await?;
        let devices = self.engine.devices()?;
        let sources = self.engine.sources(self.source)?;
        let ingest = Ingest { sources, lake: self.into, devices, rehash: self.rehash };
        let summary = ingest.run(&session, &mut |done| progress(&shown(done))).await;
        progress("");
        tell(&summary?)?;
        Ok(Status::Good)
    }
}

fn shown(done: Progress) -> String {
    let percent = (done.bytes * 100).checked_div(done.all_bytes).unwrap_or(100);
    format!("{} of {} files, {percent} %", done.files, done.all_files)
}

fn tell(summary: &Summary) -> Result<(), Failure> {
    for (name, reason) in summary.broken.iter().take(TOLD) {
        diagnostic(&format!("{name}: {reason}"));
    }
    if summary.broken.len() > TOLD {
        diagnostic(&format!("and {} more; the table captures has all of them", summary.broken.len() - TOLD));
    }
    let Summary { added, replaced, known, copies, broken, rows, bytes } = summary;
    print(&format!(
        "{added} added, {replaced} replaced, {known} already there, {copies} copies, {} not readable to their end; \
         {rows} rows, {bytes} bytes written",
        broken.len()
    ))?;
    Ok(())
}
