//! `canvass-fleet decode`, `signals` and `diagnose`: the contents of captures as one table, for programs that read
//! Parquet or Arrow.

use super::sql::Answers;
use crate::cli::Engine;
use crate::output::{self, WholeFile};
use crate::status::{Failure, Status};
use anyhow::anyhow;
use canvass_fleet::render::Format;
use canvass_fleet::scan::register_files;
use canvass_fleet::table::Table;
use std::path::PathBuf;

/// Write all messages or events of captures as a table for other programs
///
/// The columns are those of the tables `messages` and `events` (`canvass-fleet schema`). Each capture is decoded
/// separately.
#[derive(clap::Args)]
pub struct Decode {
    /// Write events instead of frames: whole SDO transfers, states, errors, layer setting, COB-IDs and mappings
    #[arg(long)]
    events: bool,
    #[command(flatten)]
    export: Export,
}

/// Write the values of all process data of captures as a table for other programs
///
/// The columns are those of the table `signals` (`canvass-fleet schema`): a row for each value.
#[derive(clap::Args)]
pub struct Signals {
    #[command(flatten)]
    export: Export,
}

/// Write the findings of the diagnosis of captures as a table for other programs
///
/// The columns are those of the table `findings` (`canvass-fleet schema`). Each capture is diagnosed separately.
#[derive(clap::Args)]
pub struct Diagnose {
    #[command(flatten)]
    export: Export,
}

/// Captures and the format of the table.
#[derive(clap::Args)]
struct Export {
    /// Captures: files, folders and patterns, here or as s3://BUCKET/...
    #[arg(required = true, value_name = "SOURCE")]
    sources: Vec<String>,
    /// How to write the table
    #[arg(long, value_enum, default_value_t = Format::Arrow)]
    format: Format,
    /// Write the table to a file instead of standard output
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    engine: Engine,
}

impl Decode {
    pub async fn run(self) -> Result<Status, Failure> {
        self.export.table(if self.events { Table::Events } else { Table::Messages }).await
    }
}

impl Signals {
    pub async fn run(self) -> Result<Status, Failure> {
        self.export.table(Table::Signals).await
    }
}

impl Diagnose {
    pub async fn run(self) -> Result<Status, Failure> {
        self.export.table(Table::Findings).await
    }
}

impl Export {
    async fn table(self, table: Table) -> Result<Status, Failure> {
        output::refuse_terminal(self.format, self.output.as_deref())?;
        let session = self.engine.session().await?;
        register_files(&session, &self.engine.sources(self.sources)?)?;
        let answers = Answers::new(session, self.format, usize::MAX);
        let statement = format!("SELECT * FROM {}", table.name());
        let file = self.output.as_deref().map(WholeFile::create).transpose()?;
        let unreadable = answers
            .all(&statement, || match &file {
                Some(file) => Ok(file.writer()?),
                None => Ok(output::raw()),
            })
            .await?;
        file.map_or(Ok(()), WholeFile::complete)?;
        // Unreadable files are reported; the rows of all others have been written.
        if unreadable > 0 {
            return Err(anyhow!("some captures could not be read").into());
        }
        Ok(Status::Good)
    }
}
