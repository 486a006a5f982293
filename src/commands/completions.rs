//! `canvass completions`: completion scripts for shells.

use crate::cli::Cli;
use crate::output::print;
use crate::status::{Failure, Status};
use clap::CommandFactory;
use clap_complete::Shell;

/// Print a completion script for a shell
///
/// For bash: canvass completions bash > ~/.local/share/bash-completion/completions/canvass
#[derive(clap::Args)]
pub struct Args {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Cli::command(), "canvass", &mut script);
        print(&String::from_utf8_lossy(&script))?;
        Ok(Status::Good)
    }
}
