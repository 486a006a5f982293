//! Exit statuses of the program, and of errors.

use canvass_bus::BusError;
use canvass_suite::runner::RunError;
use canvass_traces::{OpenError, WriteError};
use std::process::ExitCode;

/// The exit status of the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// Success.
    Good = 0,
    /// Findings, failures, or violations found by the fuzzer.
    Findings = 1,
    /// Wrong usage or unreadable input.
    Usage = 2,
    /// The bus or device could not be reached, or no case ran.
    Unreachable = 3,
}

impl From<Status> for ExitCode {
    fn from(status: Status) -> Self {
        Self::from(status as u8)
    }
}

/// An error, and the exit status with which the program then ends.
#[derive(Debug)]
pub struct Failure {
    status: Status,
    error: anyhow::Error,
}

impl Failure {
    /// The bus or device could not be reached, or no case ran.
    pub fn unreachable(error: impl Into<anyhow::Error>) -> Self {
        Self { status: Status::Unreachable, error: error.into() }
    }

    /// Prints the error, unless it is only a closed standard output.
    pub fn report(&self) -> Status {
        if self.is_broken_pipe() {
            return Status::Good;
        }
        crate::output::diagnostic(&format!("canvass: {}", self.message()));
        self.status
    }

    /// The error and its causes; a cause that repeats the text before it is left out.
    fn message(&self) -> String {
        let message =
            self.error.chain().map(ToString::to_string).fold(String::new(), |message, cause| match message.as_str() {
                "" => cause,
                _ if message.contains(&cause) => message,
                _ => format!("{message}: {cause}"),
            });
        self.error.chain().find_map(advice).map_or_else(|| message.clone(), |advice| format!("{message}; {advice}"))
    }

    fn is_broken_pipe(&self) -> bool {
        let broken = |error: &std::io::Error| error.kind() == std::io::ErrorKind::BrokenPipe;
        self.error.chain().any(|cause| cause.downcast_ref().is_some_and(broken))
    }
}

/// By default an error counts as wrong usage: most come from arguments or files.
impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self { status: Status::Usage, error: error.into() }
    }
}

/// Whether a file is a device description by its name.
fn is_description(name: &str) -> bool {
    let ending = name.rsplit('.').next().unwrap_or_default().to_ascii_lowercase();
    ["eds", "dcf", "xdd", "xdc"].contains(&&*ending)
}

/// The option that helps against an error. The program adds this advice, since its libraries do not know its options.
fn advice(cause: &(dyn std::error::Error + 'static)) -> Option<&'static str> {
    if let Some(OpenError::Unknown { name }) = cause.downcast_ref() {
        return Some(match is_description(name) {
            true => "a device description is given by --device NODE=FILE; `canvass eds show` shows it",
            false => "if you know which, use --format-in",
        });
    }
    if let Some(BusError::Interrupted { .. }) = cause.downcast_ref() {
        return Some("--reconnect-timeout sets how long to wait");
    }
    if let Some(RunError::OtherClients { .. }) = cause.downcast_ref() {
        return Some("stop them, or test the device beside them with --allow other-clients");
    }
    let Some(WriteError::NotWritten(_)) = cause.downcast_ref() else { return None };
    Some("choose another format with --to (`canvass list formats` shows them)")
}
