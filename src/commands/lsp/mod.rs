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
    /// Accepted and ignored: some editors pass it, and the server always uses standard input and output
    #[arg(long)]
    stdio: bool,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let _ = self.stdio;
        let (connection, threads) = pipes::connect();
        let (id, asked) = connection
            .initialize_start()
            .context("expected an editor that starts a session, found end of input")
            .map_err(failed)?;
        let mut session = Session::new(serde_json::from_value(asked).context("initialize").map_err(failed)?);
        let capabilities = serde_json::to_value(session.capabilities()).map_err(failed)?;
        connection
            .initialize_finish(id, capabilities)
            .context("expected an editor that starts a session, found end of input")
            .map_err(failed)?;
        let ended = session.serve(&connection, &mut raw());
        // The writing thread ends when its last sender is dropped.
        drop(connection);
        threads.join().map_err(failed)?;
        ended.map_err(failed)?;
        Ok(Status::Good)
    }
}

fn failed(error: impl Into<anyhow::Error>) -> Failure {
    Failure::from(anyhow!("{:#}", error.into()))
}
