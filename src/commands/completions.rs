//! `canvass completions`: completion scripts for shells.

use crate::output::{raw, unless_closed};
use crate::status::{Failure, Status};
use clap_complete::Shell;
use std::io::Write;

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
        unless_closed(raw().write_all(&script))?;
        Ok(Status::Good)
    }
}
