//! `canvass eds check`: everything that is wrong in device descriptions.

use crate::devices::{read, summary};
use crate::output::print;
use crate::status::{Failure, Status};
use canvass_analyzer::dictionary::Severity;
use canvass_reports::escape::{Printable, printable};
use std::fmt::Write;
use std::path::PathBuf;

/// Print everything that is wrong in device descriptions, one line each
///
/// An error could not be used; a warning is against the standard, and was understood all the same. The exit status is 1
/// if there are errors.
#[derive(clap::Args)]
pub struct Args {
    /// The files
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Args {
    pub fn run(self) -> Result<Status, Failure> {
        let mut status = Status::Good;
        for path in self.files {
            let problems = read(&path)?.problems;
            let name = path.display().to_string();
            let name = printable(&name);
            let mut text = String::new();
            for problem in &problems {
                // Writing to a string can't fail.
                let _ = writeln!(text, "{name}: {}: {problem}", problem.severity);
            }
            let _ = writeln!(text, "{name}: {}", summary(&problems));
            print(&Printable::document(&text))?;
            if problems.iter().any(|problem| problem.severity() == Severity::Error) {
                status = Status::Findings;
            }
        }
        Ok(status)
    }
}
