//! `canvass man`: manual pages.

use crate::output::{raw, unless_closed};
use crate::status::{Failure, Status};
use anyhow::{Context, anyhow};
use std::io::Write;
use std::path::PathBuf;

/// Print the manual page, or write those of all commands into a folder
#[derive(clap::Args)]
pub struct Args {
    /// A command, such as sdo read (default: canvass itself)
    command: Vec<String>,
    /// Write canvass.1, canvass-decode.1 and so on into this folder
    #[arg(long, value_name = "FOLDER", conflicts_with = "command")]
    out: Option<PathBuf>,
}

impl Args {
    /// Prints or writes the pages; `cli` is the whole command line.
    pub fn run(self, mut cli: clap::Command) -> Result<Status, Failure> {
        cli.build();
        if let Some(folder) = self.out {
            clap_mangen::generate_to(cli, &folder).with_context(|| format!("can't write to {}", folder.display()))?;
            return Ok(Status::Good);
        }
        let words: Vec<&str> = self.command.iter().flat_map(|words| words.split_whitespace()).collect();
        let mut command = &cli;
        for name in &words {
            let unknown = || anyhow!("there is no command \"{}\"", words.join(" "));
            command = command.find_subcommand(name).ok_or_else(unknown)?;
        }
        let mut page = Vec::new();
        clap_mangen::Man::new(command.clone()).render(&mut page)?;
        unless_closed(raw().write_all(&page))?;
        Ok(Status::Good)
    }
}
