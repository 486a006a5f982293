//! `canvass completions`: completion scripts for shells.

use crate::completion::VARIABLE;
use crate::output::{raw, unless_closed};
use crate::status::{Failure, Status};
use anyhow::anyhow;
use clap_complete::env::Shells;
use std::io::Write;

/// Print a completion script for a shell
///
/// The script asks canvass itself for the commands, the options and their values, such as models, faults, cases and
/// interfaces. For bash: canvass completions bash > ~/.local/share/bash-completion/completions/canvass
#[derive(clap::Args)]
pub struct Args {
    /// The shell
    #[arg(value_parser = ["bash", "elvish", "fish", "powershell", "zsh"])]
    shell: String,
}

/// Bus addresses and devices contain colons and equal signs, at which bash would otherwise break words.
const WHOLE_WORDS: &str = "COMP_WORDBREAKS=${COMP_WORDBREAKS//[:=]/}\n";

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let (shells, mut script) = (Shells::builtins(), Vec::new());
        let shell = shells.completer(&self.shell).ok_or_else(|| anyhow!("no completions for {}", self.shell))?;
        if shell.name() == "bash" {
            script.extend_from_slice(WHOLE_WORDS.as_bytes());
        }
        shell.write_registration(VARIABLE, "canvass", "canvass", "canvass", &mut script)?;
        unless_closed(raw().write_all(&script))?;
        Ok(Status::Good)
    }
}
