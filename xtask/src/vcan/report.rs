//! The reports of the machines about their tests.

use super::FOLDER;
use anyhow::{Result, ensure};
use std::fmt;
use std::fs;
use std::time::Duration;

/// A line that `tests/vcan/init` prints about a test.
pub enum Line {
    /// A test begins.
    Begin(Uptime),
    /// A test has ended.
    End {
        /// The name of the test.
        name: String,
        /// The exit status: 0 if the test passed.
        status: String,
        /// The machine's clock.
        uptime: Uptime,
    },
    /// All tests have ended.
    All,
}

/// `/proc/uptime`: seconds since the start of a machine, and idle seconds among them.
#[derive(Clone, Copy, Default)]
pub struct Uptime {
    total: f64,
    idle: f64,
}

impl Uptime {
    fn of(total: &str, idle: &str) -> Option<Self> {
        Some(Self { total: total.parse().ok()?, idle: idle.parse().ok()? })
    }

    pub fn since(self, earlier: Self) -> Self {
        Self { total: self.total - earlier.total, idle: self.idle - earlier.idle }
    }
}

impl Line {
    pub fn of(line: &str) -> Option<Self> {
        // Output of the kernel or the firmware may precede the line.
        let words: Vec<&str> = line.split_once("vcan: ")?.1.split_whitespace().collect();
        match words[..] {
            ["begin", _, total, idle] => Some(Self::Begin(Uptime::of(total, idle)?)),
            ["end", name, status, total, idle] => {
                let (name, status) = (name.to_owned(), status.to_owned());
                Some(Self::End { name, status, uptime: Uptime::of(total, idle)? })
            }
            ["all"] => Some(Self::All),
            _ => None,
        }
    }
}

/// A test that has ended.
pub struct Ended {
    pub name: String,
    /// The exit status: 0 if the test passed.
    pub status: String,
    /// Duration in seconds on this computer.
    pub wall: f64,
    /// Seconds of QEMU's processor time.
    pub cpu: f64,
    /// Duration on the machine's clock.
    pub took: Uptime,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let how = if self.status == "0" { "ok    " } else { "FAILED" };
        let Self { name, wall, cpu, took, .. } = self;
        let busy = took.total - took.idle;
        write!(
            f,
            "{how} {name}: {wall:.1} s (processor {cpu:.1} s, {busy:.1} G instructions, {:.0} s on its clock)",
            took.total
        )
    }
}

/// The results of all tests.
#[derive(Default)]
pub struct Report {
    ended: Vec<Ended>,
    missing: Vec<String>,
}

impl Report {
    /// Adds the tests that a machine has ended; `names` are all tests that it got.
    pub fn add(&mut self, names: &[String], ended: Vec<Ended>) {
        let is_missing = |name: &&String| ended.iter().all(|test| test.name != **name);
        self.missing.extend(names.iter().filter(is_missing).cloned());
        self.ended.extend(ended);
    }

    /// Prints the totals, and writes the cost of each test into a file.
    ///
    /// # Errors
    /// The names of tests that failed, or did not run.
    pub fn finish(mut self, wall: Duration) -> Result<()> {
        self.ended.sort_by(|a, b| b.cpu.total_cmp(&a.cpu));
        let costs: String = self.ended.iter().map(|test| format!("{:.1} {}\n", test.cpu, test.name)).collect();
        fs::write(format!("{FOLDER}/costs.txt"), costs)?;
        let failed: Vec<&str> =
            self.ended.iter().filter(|test| test.status != "0").map(|test| test.name.as_str()).collect();
        let passed = self.ended.len() - failed.len();
        eprintln!("{passed} tests on vcan passed, {} failed, in {:.0} s", failed.len(), wall.as_secs_f64());
        ensure!(self.missing.is_empty(), "these tests on vcan did not run: {}", self.missing.join(", "));
        ensure!(failed.is_empty(), "these tests on vcan failed: {}", failed.join(", "));
        Ok(())
    }
}
