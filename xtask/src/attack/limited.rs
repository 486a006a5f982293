//! Runs of the program with limits of memory and time.

use crate::run::target_folder;
use anyhow::{Context, Result, ensure};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// All memory that the program may ask for, in KiB; what is in use of it is less. That of a build without optimisation.
const MEMORY: u64 = 400_000;
/// Seconds of a processor.
const CPU: u64 = 20;

/// The program under attack.
pub struct Program(PathBuf);

/// How a run ended.
pub struct Limited {
    /// `None`: by a signal.
    pub status: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
    pub took: Duration,
}

impl Program {
    pub fn built() -> Result<Self> {
        let program = target_folder().join("debug/canvass");
        ensure!(program.exists(), "{} is not there", program.display());
        Ok(Self(program))
    }

    pub fn run(&self, args: &[String]) -> Limited {
        let begun = Instant::now();
        let shell = format!("ulimit -v {MEMORY} && ulimit -t {CPU} && exec \"$0\" \"$@\"");
        let output = Command::new("sh")
            .args(["-c", &shell])
            .arg(&self.0)
            .args(args)
            // Each thread would reserve 64 MiB of addresses beforehand.
            .env("MALLOC_ARENA_MAX", "1")
            .env("RUST_BACKTRACE", "0")
            .stdin(Stdio::null())
            .output();
        let took = begun.elapsed();
        match output {
            Ok(output) => Limited {
                status: output.status.code(),
                stdout: output.stdout,
                stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
                took,
            },
            Err(error) => Limited { status: None, stdout: Vec::new(), stderr: error.to_string(), took },
        }
    }

    /// Runs it to a good end.
    pub fn good(&self, args: &[&str]) -> Result<Vec<u8>> {
        let args: Vec<String> = args.iter().map(|&arg| arg.to_owned()).collect();
        let run = self.run(&args);
        ensure!(run.status == Some(0), "canvass {} ended with {:?}: {}", args.join(" "), run.status, run.stderr);
        Ok(run.stdout)
    }
}

impl Limited {
    /// What must not happen, whatever the program was given.
    pub fn breach(&self) -> Option<String> {
        let first = self.stderr.lines().find(|line| line.contains("panicked") || line.contains("memory allocation"));
        match (first, self.status) {
            (Some(line), _) => Some(line.to_owned()),
            (None, Some(0..=3)) => None,
            (None, status) => {
                Some(format!("ended with {status:?}: {}", self.stderr.lines().last().unwrap_or_default()))
            }
        }
    }
}

/// The most memory that a child of this process had in use, in MiB.
pub fn worst_memory() -> Result<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).context("getrusage")?;
    Ok(usage.max_rss() as u64 / 1024)
}
