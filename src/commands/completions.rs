//! `canvass completions`: completion scripts for shells.

use crate::output::print;
use crate::status::{Failure, Status};
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
    /// `cli` is the whole command line.
    pub fn run(self, mut cli: clap::Command) -> Result<Status, Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut cli, "canvass", &mut script);
        print(&String::from_utf8_lossy(&script))?;
        Ok(Status::Good)
    }
}
