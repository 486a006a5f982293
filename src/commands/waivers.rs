//! `canvass waivers`: files of accepted failures.

use super::compare::read;
use crate::output::{Color, TextJsonOrMarkdown, terminal_width};
use crate::provenance::date_of_file;
use crate::status::{Failure, Status};
use anyhow::Context;
use canvass_reports::document::Style;
use canvass_reports::waivers::{CheckedWaivers, breaches};
use canvass_suite::waiver::Waivers;
use canvass_traces::small_file::{self, OF_HAND};
use std::path::PathBuf;

/// Look after a file of accepted failures
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    Check(Check),
}

/// Compare a waiver file with a result: which waivers are used, which excuse nothing, and which are too wide
///
/// The result is that of `canvass test --format json`, with or without the waivers. An unused waiver is shown with the
/// breaches that differ from it in one property. Exit status 1 if a waiver is unused, too wide or expired. `canvass test
/// --write-waivers FILE` writes entries for what failed.
#[derive(clap::Args)]
struct Check {
    /// The waiver file (TOML, see `docs/waivers.md`)
    waivers: PathBuf,
    /// A result of `canvass test --format json`
    result: PathBuf,
    /// How to print the waivers
    #[arg(long, value_enum, default_value_t)]
    format: TextJsonOrMarkdown,
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        match self.action {
            Action::Check(check) => check.run(color),
        }
    }
}

impl Check {
    fn run(self, color: Color) -> Result<Status, Failure> {
        let (file, result_file) = (self.waivers.display().to_string(), self.result.display().to_string());
        let text = small_file::read_text(&self.waivers, OF_HAND).with_context(|| format!("can't read {file}"))?;
        let waivers = Waivers::read(&text).with_context(|| file.clone())?;
        let found = breaches(&read(&self.result)?).with_context(|| result_file.clone())?;
        let today = date_of_file()?.date().to_string();
        let checked = CheckedWaivers { file, result: result_file, checked: waivers.checked(&today, &found) };
        let style = Style { color: color.on_stdout(), width: terminal_width() };
        self.format.print(&checked, style)?;
        Ok(if checked.is_good() { Status::Good } else { Status::Findings })
    }
}
