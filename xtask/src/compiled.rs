//! Runs cargo, and collects its products and warnings.

use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Command, Stdio};

/// The features that CI compiles at once, including those of tests with steps of their own: other programs, a
/// browser, or a kernel with CAN.
pub const FEATURES: [&str; 2] = ["--features", "canvass/peers,canvass/browser,canvass/vcan,canvass/page"];

/// The result of a call of cargo.
#[derive(Debug, Default)]
pub struct Compiled {
    /// The test programs.
    pub tests: Vec<PathBuf>,
    /// Number of warnings in this workspace.
    warnings: usize,
}

impl Compiled {
    /// Requires that there was no warning.
    ///
    /// # Errors
    /// If there was a warning.
    pub fn without_warnings(self) -> Result<Self> {
        ensure!(self.warnings == 0, "expected no warnings, found {}: see above", self.warnings);
        Ok(self)
    }

    /// Handles a message of cargo; the compiler's messages are printed.
    fn take(&mut self, message: &Value) {
        match message["reason"].as_str() {
            Some("compiler-message") => self.warnings += warned(message),
            Some("compiler-artifact") if message["profile"]["test"] == true => {
                // Uses the real path, as cargo's may lead through a link.
                let built = message["executable"].as_str().and_then(|file| std::fs::canonicalize(file).ok());
                self.tests.extend(built);
            }
            _ => {}
        }
    }
}

/// Compiles with cargo, without running anything.
///
/// # Errors
/// If cargo fails, or prints an unexpected message.
pub fn compile(cargo: &mut Command, args: &[&str]) -> Result<Compiled> {
    eprintln!("$ cargo {}", args.join(" "));
    let mut running =
        cargo.args(args).args(["--message-format", "json"]).stdout(Stdio::piped()).spawn().context("cargo")?;
    let stdout = running.stdout.take().context("cargo")?;
    let mut compiled = Compiled::default();
    for line in BufReader::new(stdout).lines() {
        compiled.take(&serde_json::from_str(&line?).context("expected a message of cargo")?);
    }
    let status = running.wait()?;
    ensure!(status.success(), "cargo ended with {status}");
    Ok(compiled)
}

/// Counts a warning, and prints the compiler's messages. Cargo passes on only the messages of this workspace, and
/// repeats them for crates that were built already.
fn warned(message: &Value) -> usize {
    let said = &message["message"];
    eprint!("{}", said["rendered"].as_str().unwrap_or_default());
    usize::from(matches!(said["level"].as_str(), Some("warning" | "error")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn warnings_are_counted_and_programs_of_tests_are_named() {
        let here = std::env::current_exe().unwrap().canonicalize().unwrap();
        let artifact = |test: bool| {
            let profile = json!({"test": test});
            json!({"reason": "compiler-artifact", "profile": profile, "executable": here.to_str()})
        };
        let said = |level| json!({"reason": "compiler-message", "message": {"level": level, "rendered": ""}});
        let mut compiled = Compiled::default();
        for message in [artifact(false), artifact(true), said("note"), json!({"reason": "build-finished"})] {
            compiled.take(&message);
        }
        assert_eq!((&compiled.tests[..], compiled.warnings), (&[here.clone()][..], 0));
        compiled.take(&said("warning"));
        assert_eq!(compiled.without_warnings().unwrap_err().to_string(), "expected no warnings, found 1: see above");
    }
}
