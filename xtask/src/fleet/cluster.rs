//! A cluster of processes on this machine, for measurements.

use anyhow::{Context, Result, ensure};
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// Number of repetitions of a query; the fastest counts.
const RUNS: usize = 3;

/// A scheduler and executors with one task each, ended on drop.
pub struct Cluster {
    /// The address of the scheduler, for `--cluster`.
    pub address: String,
    processes: Vec<Child>,
}

impl Cluster {
    /// Starts the processes, and waits until all are ready.
    pub fn start(fleet: &str, executors: usize) -> Result<Self> {
        let mut cluster = Self { address: String::new(), processes: Vec::new() };
        let said = cluster.process(fleet, &["scheduler", "--bind", "127.0.0.1:0"], "scheduler at ")?;
        let address =
            said.rsplit(' ').next().context("expected \"scheduler at ADDRESS\" in the output of the scheduler")?;
        for _ in 0..executors {
            let words = ["executor", "--scheduler", address, "--bind", "127.0.0.1:0", "--tasks", "1"];
            cluster.process(fleet, &words, "arrow flight")?;
        }
        cluster.address = format!("df://{address}");
        Ok(cluster)
    }

    /// Starts a process, and returns the line that contains `ready`, which the process prints when it is ready.
    fn process(&mut self, fleet: &str, words: &[&str], ready: &str) -> Result<String> {
        let mut child = Command::new(fleet)
            .args(words)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .with_context(|| format!("can't run {fleet}"))?;
        let told = child.stderr.take().context("standard error")?;
        self.processes.push(child);
        let mut lines = BufReader::new(told).lines().map_while(Result::ok);
        let line = lines.by_ref().find(|line| line.contains(ready));
        // The rest of the output is read, too, so that the process never blocks.
        std::thread::spawn(move || lines.for_each(drop));
        line.with_context(|| format!("{fleet} {} ended before it was ready", words.join(" ")))
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for child in &mut self.processes {
            // The process may have ended.
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// The duration of a query in seconds.
pub fn asked(fleet: &str, words: &[&str]) -> Result<f64> {
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        let began = Instant::now();
        let ended = Command::new(fleet).args(words).stdout(Stdio::null()).status()?;
        ensure!(ended.success(), "{fleet} {} ended with {ended}", words.join(" "));
        least = least.min(began.elapsed().as_secs_f64());
    }
    Ok(least)
}
