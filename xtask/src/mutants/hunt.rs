//! Runs the suite and the fuzzer on mutants, each in a process of its own that may crash or never end.

use super::area::Area;
use super::drawn::Mutant;
use super::{parallel, scratch};
use anyhow::{Context, Result, ensure};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Limit of processor time in seconds for the suite, or the fuzzer, on a mutant: many times the time on the device
/// without a mutant.
const CPU: u64 = 6;
/// Limit of memory in KiB: a mutant that fills its memory ends.
const MEMORY: u64 = 2_000_000;

/// The tool that looks for mutants.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Hunter {
    Suite,
    Fuzzer,
}

/// The result of one tool on a mutant.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// The tool found the mutant: the model, and the case or property.
    Found(String),
    /// No case failed, but a case that records what the standard leaves open recorded a difference.
    Recorded(String),
    /// The traffic differed from the traffic of the device without a mutant, and the tool found nothing.
    Survived,
    /// The traffic did not differ.
    Unseen,
    /// The run did not end.
    Hung,
}

/// The results of both tools on a mutant.
#[derive(Clone, Debug)]
pub struct Fate {
    pub mutant: Mutant,
    pub suite: Outcome,
    pub fuzzer: Outcome,
}

/// The program with all mutants.
pub struct Hunt {
    program: PathBuf,
    seed: u64,
    exchanges: u64,
}

/// The results of a device without a mutant.
pub struct Right {
    suite: String,
    fuzzer: String,
    /// The places that were reached.
    pub reached: BTreeSet<u32>,
}

/// Builds the program with all mutants.
pub fn build(area: &Area) -> Result<PathBuf> {
    eprintln!("building the program with all mutants");
    let arguments = ["build", "--profile", "mutants", "--package", "canvass-fuzzer", "--example", "mutant"];
    let status = scratch::cargo(area, &arguments).status().context("cargo build")?;
    ensure!(status.success(), "the mutated workspace does not build: {status}");
    Ok(std::env::current_dir()?.join(area.scratch()).join("target/mutants/examples/mutant"))
}

impl Outcome {
    pub const fn is_found(&self) -> bool {
        matches!(self, Self::Found(_) | Self::Recorded(_))
    }
}

impl Fate {
    pub const fn is_found(&self) -> bool {
        self.suite.is_found() || self.fuzzer.is_found()
    }

    /// Whether neither tool saw a difference in the traffic.
    pub fn is_unseen(&self) -> bool {
        self.suite == Outcome::Unseen && self.fuzzer == Outcome::Unseen
    }

    /// Whether the mutant did not end, and neither tool found it before.
    pub fn has_hung(&self) -> bool {
        !self.is_found() && (self.suite == Outcome::Hung || self.fuzzer == Outcome::Hung)
    }
}

impl Hunt {
    pub fn new(program: PathBuf, seed: u64, exchanges: u64) -> Self {
        Self { program, seed, exchanges }
    }

    /// Runs both tools on the device without a mutant, where they must find nothing.
    pub fn right(&self, folder: &Path) -> Result<Right> {
        let mut reached = BTreeSet::new();
        let mut texts = Vec::new();
        for hunter in [Hunter::Suite, Hunter::Fuzzer] {
            let list = std::env::current_dir()?.join(folder).join("reached.txt");
            let (text, ended) = self.run(hunter, &[("CANVASS_MUTANTS_REACHED", &list.to_string_lossy())])?;
            ensure!(ended, "{hunter:?} does not come to an end on the device without a mutant, after\n{text}");
            let is_clean = !text.contains(" found ") && !text.contains(" recorded ");
            ensure!(is_clean, "something is found on the device without a mutant:\n{text}");
            let list = std::fs::read_to_string(&list)?;
            reached.extend(list.lines().filter_map(|line| line.parse::<u32>().ok()));
            texts.push(text);
        }
        let fuzzer = texts.pop().unwrap_or_default();
        Ok(Right { suite: texts.pop().unwrap_or_default(), fuzzer, reached })
    }

    /// Runs both tools on all mutants.
    pub fn all(&self, mutants: &[Mutant], right: &Right) -> Result<Vec<Fate>> {
        parallel::each(mutants, 100, |mutant| {
            let suite = self.one(Hunter::Suite, mutant, &right.suite)?;
            let fuzzer = match suite {
                // A mutant on which the suite hangs would hang here as well.
                Outcome::Hung => Outcome::Hung,
                _ => self.one(Hunter::Fuzzer, mutant, &right.fuzzer)?,
            };
            let fate = Fate { mutant: mutant.clone(), suite, fuzzer };
            // A long run prints each surviving mutant at once.
            if !fate.is_found() && !fate.is_unseen() {
                eprintln!("{}", super::table::describe(&fate));
            }
            Ok(fate)
        })
    }

    fn one(&self, hunter: Hunter, mutant: &Mutant, right: &str) -> Result<Outcome> {
        let (text, ended) = self.run(hunter, &[("CANVASS_MUTANT", &mutant.number.to_string())])?;
        let told = |word: &str| text.lines().find(|line| line.contains(word)).map(|line| line.replacen(word, ": ", 1));
        Ok(match told(" found ").map(Outcome::Found).or_else(|| told(" recorded ").map(Outcome::Recorded)) {
            Some(told) => told,
            None if !ended => Outcome::Hung,
            None if text == right => Outcome::Unseen,
            None => Outcome::Survived,
        })
    }

    /// Runs a tool; returns its output, and whether it ended.
    fn run(&self, hunter: Hunter, environment: &[(&str, &str)]) -> Result<(String, bool)> {
        let word = if hunter == Hunter::Suite { "suite" } else { "fuzz" };
        let shell = format!("ulimit -v {MEMORY} && ulimit -t {CPU} && exec \"$0\" \"$@\"");
        let output = Command::new("sh")
            .args(["-c", &shell])
            .arg(&self.program)
            .args([word, &self.seed.to_string(), &self.exchanges.to_string()])
            .envs(environment.iter().copied())
            .env("RUST_BACKTRACE", "0")
            .stderr(Stdio::null())
            .stdin(Stdio::null())
            .output()
            .context("the program with all mutants")?;
        Ok((String::from_utf8_lossy(&output.stdout).into_owned(), output.status.success()))
    }
}
