//! `canvass lsp`: a language server for EDS and DCF files, which editors start.

mod answers;
mod document;
mod pipes;
mod session;

use crate::output::raw;
use crate::status::{Failure, Status};
use anyhow::{Context, anyhow};
use session::Session;

/// Language server for EDS and DCF files: findings while typing, hover texts, completion, outline and edits
///
/// Editors start it and communicate with it by the Language Server Protocol over standard input and output.
#[derive(clap::Args)]
pub struct Args {
    /// Standard input and output, as always: some editors say so
    #[arg(long)]
    stdio: bool,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let _ = self.stdio;
        let (connection, threads) = pipes::connect();
        let (id, asked) = connection.initialize_start().context("no editor has begun a session").map_err(failed)?;
        let mut session = Session::new(serde_json::from_value(asked).context("initialize").map_err(failed)?);
        let capabilities = serde_json::to_value(session.capabilities()).map_err(failed)?;
        connection.initialize_finish(id, capabilities).context("no editor has begun a session").map_err(failed)?;
        let ended = session.serve(&connection, &mut raw());
        // The threads end when nobody can send any more.
        drop(connection);
        threads.join().map_err(failed)?;
        ended.map_err(failed)?;
        Ok(Status::Good)
    }
}

fn failed(error: impl Into<anyhow::Error>) -> Failure {
    Failure::from(anyhow!("{:#}", error.into()))
}
