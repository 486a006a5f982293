//! The results of an attack.

use super::account::Accounted;
use super::limited::{Limited, worst_memory};
use std::fmt;
use std::time::Duration;

/// Time limit of a run on any file.
const MOST: Duration = Duration::from_secs(20);

#[derive(Default)]
pub struct Tally {
    pub inputs: u64,
    pub runs: u64,
    /// Number of captures whose rows were counted, and number of their rows.
    accounted: u64,
    rows: u64,
    /// Number of changed rows that look like no frame any more, such as comments.
    became_others: u64,
    worst: (Duration, String),
    pub rogues: u64,
    pub failures: Vec<String>,
}

impl Tally {
    /// Counts a run; returns its failure, if there is one.
    pub fn take(&mut self, run: &Limited, args: &[String]) -> Option<String> {
        self.runs += 1;
        if run.took > self.worst.0 {
            self.worst = (run.took, args.join(" "));
        }
        let command = || format!("canvass {}", args.join(" "));
        match run.breach() {
            Some(breach) => Some(format!("{}: {breach}", command())),
            None if run.took > MOST => Some(format!("{}: took {:.1} s", command(), run.took.as_secs_f64())),
            None => None,
        }
    }

    /// Counts the account of a capture; returns unreported losses.
    pub fn account(&mut self, accounted: Accounted) -> Option<String> {
        self.runs += 1;
        self.accounted += 1;
        self.rows += accounted.rows;
        self.became_others += accounted.became_others;
        accounted.silent_loss
    }

    pub fn add(&mut self, other: Self) {
        self.inputs += other.inputs;
        self.runs += other.runs;
        self.accounted += other.accounted;
        self.rows += other.rows;
        self.became_others += other.became_others;
        self.rogues += other.rogues;
        self.failures.extend(other.failures);
        if other.worst.0 > self.worst.0 {
            self.worst = other.worst;
        }
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "changed files     {}", self.inputs)?;
        writeln!(f, "runs              {}", self.runs)?;
        writeln!(f, "rogue adapters    {} runs", self.rogues)?;
        writeln!(f, "frames accounted  in {} captures, {} rows of them counted", self.accounted, self.rows)?;
        writeln!(
            f,
            "became others     {} rows that the change made a comment or another known kind",
            self.became_others
        )?;
        writeln!(f, "worst time        {:.2} s: canvass {}", self.worst.0.as_secs_f64(), self.worst.1)?;
        writeln!(f, "worst memory      {} MiB", worst_memory().unwrap_or_default())?;
        write!(f, "failed            {}", self.failures.len())
    }
}
