//! Runs the program as a user does.

use std::io::{ErrorKind, Write};
use std::process::{Command, Output, Stdio};

/// The result of a run.
pub struct Run {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

/// The program with these arguments, in the project's folder, without colours from the environment.
pub fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canvass"));
    command.args(args).env_remove("NO_COLOR").current_dir(env!("CARGO_MANIFEST_DIR"));
    command
}

/// Presses Ctrl-C; returns whether that was possible.
#[cfg(unix)]
pub fn interrupt(child: &std::process::Child) -> bool {
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().is_ok()
}

pub fn run(args: &[&str]) -> Run {
    finished(command(args).stdin(Stdio::null()).output().unwrap())
}

/// Runs the program with a text on standard input.
pub fn run_with_input(args: &[&str], input: &str) -> Run {
    let mut child = command(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let written = child.stdin.take().unwrap().write_all(input.as_bytes());
    // A program that ends for another reason need not read its input.
    if let Err(error) = written {
        assert_eq!(error.kind(), ErrorKind::BrokenPipe);
    }
    finished(child.wait_with_output().unwrap())
}

pub fn finished(output: Output) -> Run {
    Run {
        status: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}
