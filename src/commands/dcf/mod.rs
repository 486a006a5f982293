//! `canvass dcf`: the configurations of devices, in DCF and XDC files.

mod allow;
mod backup;
mod convert;
mod device;
mod diff;
mod file;
mod journal;
mod read;
mod write;

use crate::output::Color;
use crate::status::{Failure, Status};

/// Read, compare, write and keep the configurations of devices: DCF, XDC and concise DCF files
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    Read(read::Args),
    Write(write::Args),
    Diff(diff::Args),
    Convert(convert::Args),
    Backup(backup::Args),
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        match self.action {
            Action::Read(args) => args.run(),
            Action::Write(args) => args.run(color),
            Action::Diff(args) => args.run(color),
            Action::Convert(args) => args.run(),
            Action::Backup(args) => args.run(),
        }
    }
}
