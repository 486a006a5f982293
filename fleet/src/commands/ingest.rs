//! `canvass-fleet ingest`: captures and results into a lake.

use crate::cli::Engine;
use crate::output::{diagnostic, print, progress};
use crate::status::{Failure, Status};
use canvass_fleet::capture::is_url;
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
    /// The place where the files were recorded, such as a test bench: files of two sites with equal paths are
    /// different files [default: this computer's name for a lake in an object store]
    #[arg(long, value_name = "NAME", value_parser = site)]
    site: Option<String>,
    #[command(flatten)]
    engine: Engine,
}

/// A site in the name of a file: `SITE:/path`.
fn site(text: &str) -> Result<String, String> {
    let is_fine = !text.is_empty() && !text.contains(['/', ':']) && !text.contains(char::is_control);
    if is_fine { Ok(text.to_owned()) } else { Err("expected a name without / and :".to_owned()) }
}

/// The name of this computer, if the system tells it.
fn host() -> Option<String> {
    let named =
        std::fs::read_to_string("/proc/sys/kernel/hostname").ok().or_else(|| std::env::var("COMPUTERNAME").ok());
    named.and_then(|name| site(name.trim()).ok())
}

/// Maximum number of broken files that are reported one by one.
const TOLD: usize = 20;

impl Args {
    pub async fn run(self) -> Result<Status, Failure> {
        let session = self.engine.session().await?;
        let devices = self.engine.devices()?;
        let sources = self.engine.sources(self.source)?;
        // Several computers share a lake in an object store, often with equal folders.
        let site = self.site.or_else(|| is_url(&self.into).then(host).flatten());
        let ingest = Ingest { sources, lake: self.into, devices, rehash: self.rehash, site };
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
