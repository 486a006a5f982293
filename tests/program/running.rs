//! Running the program as a user does.

use std::io::{ErrorKind, Write};
use std::process::{Child, Command, Output, Stdio};

/// What a run left behind.
pub struct Run {
    pub status: i32,
    pub stdout: String,
    pub stderr: String,
}

/// The program with these arguments, in the project's folder, without colours from the environment.
pub fn command(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canvass"));
    command.args(args).env_remove("NO_COLOR").current_dir(env!("CARGO_MANIFEST_DIR"));
    // So that it can be interrupted, and not these tests with it.
    #[cfg(windows)]
    std::os::windows::process::CommandExt::creation_flags(
        &mut command,
        windows_sys::Win32::System::Threading::CREATE_NEW_PROCESS_GROUP,
    );
    command
}

/// What a user does who wants a run to end: Ctrl-C, or Ctrl-Break on Windows, which reaches programs that do not own the
/// console. Says whether it could be done.
pub fn interrupt(child: &Child) -> bool {
    #[cfg(unix)]
    {
        Command::new("kill").args(["-INT", &child.id().to_string()]).status().is_ok()
    }
    #[cfg(windows)]
    {
        use windows_sys::Win32::System::Console::{CTRL_BREAK_EVENT, GenerateConsoleCtrlEvent};
        #[expect(unsafe_code, reason = "the standard library has no such function")]
        // SAFETY: two numbers; the process has a group of its own.
        let sent = unsafe { GenerateConsoleCtrlEvent(CTRL_BREAK_EVENT, child.id()) };
        sent != 0
    }
}

pub fn run(args: &[&str]) -> Run {
    finished(command(args).stdin(Stdio::null()).output().unwrap())
}

/// Runs with a text on standard input.
pub fn run_with_input(args: &[&str], input: &str) -> Run {
    let mut child = command(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let written = child.stdin.take().unwrap().write_all(input.as_bytes());
    // A program that ends for another reason need not read.
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
