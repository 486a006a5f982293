//! `canvass eds`: device descriptions.

mod check;
mod convert;
pub mod device;
mod diff;
pub mod found;
pub mod from_device;
mod show;
mod verify;

use crate::output::Color;
use crate::status::{Failure, Status};

/// Check, show, compare and convert device descriptions: EDS, DCF and XDD files
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    Check(check::Args),
    Convert(convert::Args),
    Diff(diff::Args),
    FromDevice(from_device::Args),
    Show(show::Args),
    Verify(verify::Args),
}

impl Args {
    pub fn run(self, color: Color) -> Result<Status, Failure> {
        match self.action {
            Action::Check(args) => args.run(color),
            Action::Convert(args) => args.run(),
            Action::Diff(args) => args.run(color),
            Action::FromDevice(args) => args.run(),
            Action::Show(args) => args.run(color),
            Action::Verify(args) => args.run(color),
        }
    }
}
