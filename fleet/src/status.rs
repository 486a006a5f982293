//! Exit statuses, the same as those of `canvass`.

use crate::output::diagnostic;
use std::process::ExitCode;

/// The exit status of the program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Status {
    /// Success.
    Good = 0,
    /// Wrong usage or unreadable input.
    Usage = 2,
    /// The cluster could not be reached.
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
    /// The cluster could not be reached.
    pub fn unreachable(error: impl Into<anyhow::Error>) -> Self {
        Self { status: Status::Unreachable, error: error.into() }
    }

    /// Prints the error, unless it is only a closed standard output.
    pub fn report(&self) -> Status {
        if self.is_broken_pipe() {
            return Status::Good;
        }
        diagnostic(&format!("canvass-fleet: {}", self.message()));
        self.status
    }

    /// The error and its causes; a cause that repeats the text before it is left out.
    pub fn message(&self) -> String {
        let causes = self.error.chain().map(|cause| plain(&cause.to_string()));
        causes.fold(String::new(), |message, cause| match message.as_str() {
            "" => cause,
            _ if message.contains(&cause) => message,
            _ => format!("{message}: {cause}"),
        })
    }

    fn is_broken_pipe(&self) -> bool {
        let is_broken = |cause: &(dyn std::error::Error + 'static)| {
            let broken = |error: &std::io::Error| error.kind() == std::io::ErrorKind::BrokenPipe;
            cause.downcast_ref().is_some_and(broken)
        };
        let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(self.error.as_ref());
        while let Some(this) = cause {
            if is_broken(this) || this.to_string().contains("Broken pipe (os error 32)") {
                return true;
            }
            cause = this.source();
        }
        false
    }
}

/// The engine's message without the names of the engine's parts.
fn plain(message: &str) -> String {
    let words = ["External error: ", "Error during planning: ", "SQL error: ", "Execution error: ", "IO error: "];
    words.iter().fold(message.to_owned(), |message, word| message.replace(word, ""))
}

/// By default an error counts as wrong usage: most come from arguments, statements or files.
impl<E: Into<anyhow::Error>> From<E> for Failure {
    fn from(error: E) -> Self {
        Self { status: Status::Usage, error: error.into() }
    }
}
