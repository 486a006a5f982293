//! Runs the program with limits of memory and time.

use crate::run::target_folder;
use anyhow::{Context, Result, ensure};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Limit of the reserved addresses in KiB, for a build without optimisation. A process reserves more memory than it
/// uses.
const MEMORY: u64 = 400_000;
/// Limit of processor time in seconds.
const CPU: u64 = 20;

/// The program under attack.
pub struct Program(PathBuf);

/// The end of a run.
pub struct Limited {
    /// The exit status; `None` for a signal.
    pub status: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
    pub took: Duration,
}

impl Program {
    pub fn built() -> Result<Self> {
        let program = target_folder().join("debug/canvass");
        ensure!(program.exists(), "{} does not exist", program.display());
        Ok(Self(program))
    }

    pub fn run(&self, args: &[String]) -> Limited {
        let begun = Instant::now();
        let shell = format!("ulimit -v {MEMORY} && ulimit -t {CPU} && exec \"$0\" \"$@\"");
        let output = Command::new("sh")
            .args(["-c", &shell])
            .arg(&self.0)
            .args(args)
            // Each thread would reserve 64 MiB of addresses.
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

    /// Runs the program and requires success.
    pub fn good(&self, args: &[&str]) -> Result<Vec<u8>> {
        let args: Vec<String> = args.iter().map(|&arg| arg.to_owned()).collect();
        let run = self.run(&args);
        ensure!(run.status == Some(0), "canvass {} ended with {:?}: {}", args.join(" "), run.status, run.stderr);
        Ok(run.stdout)
    }
}

impl Limited {
    /// A behaviour that must not occur on any input.
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

/// The largest memory use of a child of this process, in MiB.
pub fn worst_memory() -> Result<u64> {
    use nix::sys::resource::{UsageWho, getrusage};
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN).context("getrusage")?;
    Ok(usage.max_rss() as u64 / 1024)
}
