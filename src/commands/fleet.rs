//! `canvass fleet`: runs `canvass-fleet`, a separate program, with the typed arguments.

use crate::status::{Failure, Status};
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Query thousands of captures and test results in SQL: runs canvass-fleet
///
/// canvass-fleet is a separate program. canvass looks for it in its own folder, then in PATH.
#[derive(clap::Args)]
#[command(disable_help_flag = true, disable_version_flag = true)]
pub struct Args {
    /// The arguments of canvass-fleet, such as sql "SELECT ..." or --help
    #[arg(value_name = "ARGUMENT", trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Why canvass-fleet does not run.
#[derive(Debug, thiserror::Error)]
enum FleetError {
    #[error(
        "{PROGRAM}, a separate program, is neither in canvass's folder nor in PATH. In the source of canvass `cargo \
         build --release --manifest-path fleet/Cargo.toml` makes fleet/target/release/{PROGRAM}"
    )]
    Missing,
    #[error("can't run {}: {source}", program.display())]
    Start { program: PathBuf, source: io::Error },
}

const PROGRAM: &str = "canvass-fleet";

impl Args {
    /// Runs canvass-fleet, whose exit status becomes that of canvass.
    pub fn run(self) -> Result<Status, Failure> {
        let program = beside().unwrap_or_else(|| PathBuf::from(PROGRAM));
        let mut command = Command::new(&program);
        command.args(self.arguments);
        Ok(ended(command).map_err(|source| not_started(&program, source))?)
    }
}

/// The path of canvass-fleet in the folder of this program.
fn beside() -> Option<PathBuf> {
    let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let program = std::env::current_exe().ok()?.parent()?.join(name);
    program.is_file().then_some(program)
}

fn not_started(program: &Path, source: io::Error) -> FleetError {
    match source.kind() {
        io::ErrorKind::NotFound if program == Path::new(PROGRAM) => FleetError::Missing,
        _ => FleetError::Start { program: program.to_owned(), source },
    }
}

/// Replaces this process by canvass-fleet, which then receives the signals and sets the exit status itself.
#[cfg(unix)]
fn ended(mut command: Command) -> io::Result<Status> {
    Err(std::os::unix::process::CommandExt::exec(&mut command))
}

#[cfg(not(unix))]
fn ended(mut command: Command) -> io::Result<Status> {
    Ok(match command.status()?.code() {
        Some(0) => Status::Good,
        Some(1) => Status::Findings,
        Some(3) => Status::Unreachable,
        _ => Status::Usage,
    })
}
