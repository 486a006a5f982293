//! What cargo builds for Windows, and what it says of it.

use super::{TARGET, plain_path};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::process::Stdio;

/// The program, which is built with its tests.
pub const PROGRAM: &str = "target/x86_64-pc-windows-gnu/debug/canvass.exe";

/// Whose tests run: those of the program, and those of the buses, which meet the system.
const TESTS: [&str; 11] = [
    "--package",
    "canvass",
    "--package",
    "canvass-bus",
    "--bin",
    "canvass",
    "--lib",
    "--test",
    "program",
    "--test",
    "pcan",
];

/// What is only built, and not run, need not be quick.
const UNOPTIMISED: [&str; 2] = ["--config", "profile.dev.package.\"*\".opt-level=0"];

/// How quick the tests shall be.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// They are run.
    Run,
    /// They are only built.
    Build,
}

/// Builds the tests, and the program with them; gives their files.
///
/// # Errors
/// If that fails, or the compiler warns of anything in this workspace.
pub fn tests(used: Use) -> Result<Vec<String>> {
    let profile = if used == Use::Build { &UNOPTIMISED[..] } else { &[] };
    let build = ["test", "--no-run", "--locked", "--target", TARGET, "--message-format", "json"];
    let args = [&build[..], profile, &TESTS].concat();
    eprintln!("$ cargo {}", args.join(" "));
    let mut cargo = plain_path::cargo()?;
    let mut running = cargo.command.args(args).stdout(Stdio::piped()).spawn().context("cargo")?;
    let stdout = running.stdout.take().context("cargo")?;
    let (mut files, mut warnings) = (Vec::new(), 0);
    for line in BufReader::new(stdout).lines() {
        let message: Value = serde_json::from_str(&line?).context("expected a message of cargo")?;
        match message["reason"].as_str() {
            Some("compiler-message") => warnings += warned(&message),
            Some("compiler-artifact") if message["profile"]["test"] == true => {
                // By the path that lasts.
                let built = message["executable"].as_str().map(std::fs::canonicalize).transpose()?;
                files.extend(built.map(|file| file.to_string_lossy().into_owned()));
            }
            _ => {}
        }
    }
    let status = running.wait()?;
    ensure!(status.success(), "cargo ended with {status}");
    ensure!(warnings == 0, "expected none, found {warnings} warnings for {TARGET}");
    Ok(files)
}

/// Shows what the compiler says. Cargo asks it for this workspace only, and repeats it where nothing had to be built.
fn warned(message: &Value) -> usize {
    let said = &message["message"];
    eprint!("{}", said["rendered"].as_str().unwrap_or_default());
    usize::from(matches!(said["level"].as_str(), Some("warning" | "error")))
}
