//! `canvass fleet`: hands what was typed to `canvass-fleet`, which is a program of its own.

use crate::status::{Failure, Status};
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Ask thousands of captures and results of tests in SQL: runs canvass-fleet
///
/// canvass-fleet is a program of its own. It is taken from the folder that canvass is in, or from PATH.
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
        "{PROGRAM} is neither beside canvass nor in PATH: it is a program of its own. In the source of canvass `cargo \
         build --release --manifest-path fleet/Cargo.toml` makes fleet/target/release/{PROGRAM}"
    )]
    Missing,
    #[error("can't run {}: {source}", program.display())]
    Start { program: PathBuf, source: io::Error },
}

const PROGRAM: &str = "canvass-fleet";

impl Args {
    /// Its exit status is that of canvass-fleet.
    pub fn run(self) -> Result<Status, Failure> {
        let program = beside().unwrap_or_else(|| PathBuf::from(PROGRAM));
        let mut command = Command::new(&program);
        command.args(self.arguments);
        Ok(ended(command).map_err(|source| not_started(&program, source))?)
    }
}

/// The one in the folder that this program is in.
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

/// This process becomes that program: its signals and its status are those of the other one.
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
