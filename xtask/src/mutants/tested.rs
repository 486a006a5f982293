//! Runs a crate's own tests on mutants of it, each in a process of its own that may crash or never end.

use super::area::Area;
use super::drawn::Mutant;
use super::scratch;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// KiB: a mutant that fills its memory ends.
const MEMORY: u64 = 4_000_000;
/// A mutant may take so many times the processor time that the tests take without one.
const SLOWER: u32 = 10;
/// And so many seconds besides.
const BESIDES: u64 = 5;

/// What became of a mutant.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// By this test.
    Caught(String),
    /// The tests came to no end within their time.
    Hung,
    /// All tests passed.
    Missed,
    /// No test comes to its place.
    Unreached,
}

/// A mutant with what became of it.
pub struct Fate {
    pub mutant: Mutant,
    pub outcome: Outcome,
}

/// A program with tests.
struct Program {
    path: PathBuf,
    /// The folder of its crate.
    folder: PathBuf,
    /// What it takes without a mutant.
    time: Duration,
    /// The places that it comes to.
    reached: BTreeSet<u32>,
}

/// The test programs of a mutated crate.
pub struct Tests(Vec<Program>);

impl Tests {
    /// Builds them, and runs them without a mutant.
    pub fn build(area: &Area) -> Result<Self> {
        eprintln!("building the tests with all mutants");
        let arguments =
            ["test", "--no-run", "--profile", "mutants", "--package", area.package, "--message-format=json"];
        let output =
            scratch::cargo(area, &arguments).stderr(Stdio::inherit()).output().context("cargo test --no-run")?;
        ensure!(output.status.success(), "the mutated tests do not build: {}", output.status);
        let lines = String::from_utf8_lossy(&output.stdout).into_owned();
        let mut programs = lines.lines().filter_map(Program::named).collect::<Vec<_>>();
        ensure!(!programs.is_empty(), "{} has no tests", area.package);
        for program in &mut programs {
            program.without_mutant()?;
        }
        // What is quick is asked first.
        programs.sort_by_key(|program| program.time);
        Ok(Self(programs))
    }

    /// How long all of them take without a mutant.
    pub fn time(&self) -> Duration {
        self.0.iter().map(|program| program.time).sum()
    }

    /// Runs the tests on all mutants, on as many threads as there are cores.
    pub fn all(&self, mutants: &[Mutant]) -> Result<Vec<Fate>> {
        let (next, fates) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let work = || -> Result<()> {
            loop {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some(mutant) = mutants.get(at) else { return Ok(()) };
                let fate = Fate { mutant: mutant.clone(), outcome: self.one(mutant)? };
                if (at + 1).is_multiple_of(50) {
                    eprintln!("{} of {}", at + 1, mutants.len());
                }
                if let Ok(mut fates) = fates.lock() {
                    fates.push(fate);
                }
            }
        };
        std::thread::scope(|scope| {
            let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
            let joined = workers.into_iter().map(|worker| worker.join());
            joined.into_iter().try_for_each(|ended| ended.unwrap_or_else(|_| anyhow::bail!("a thread failed")))
        })?;
        let mut fates = fates.into_inner().unwrap_or_default();
        fates.sort_by_key(|fate: &Fate| fate.mutant.number);
        Ok(fates)
    }

    fn one(&self, mutant: &Mutant) -> Result<Outcome> {
        let mut outcome = Outcome::Unreached;
        for program in self.0.iter().filter(|program| program.reached.contains(&mutant.place)) {
            let limit = program.time * SLOWER + Duration::from_secs(BESIDES);
            match program.run(limit, &[("CANVASS_MUTANT", &mutant.number.to_string())])? {
                Ended::Passed => outcome = Outcome::Missed,
                Ended::Failed(test) => return Ok(Outcome::Caught(test)),
                Ended::Late => return Ok(Outcome::Hung),
            }
        }
        Ok(outcome)
    }
}

impl Program {
    /// The program that a message of cargo tells of, if it holds tests.
    fn named(line: &str) -> Option<Self> {
        let message: Value = serde_json::from_str(line).ok()?;
        let is_test = message.get("profile")?.get("test")?.as_bool()?;
        let path = PathBuf::from(message.get("executable")?.as_str()?);
        let folder = Path::new(message.get("manifest_path")?.as_str()?).parent()?.to_owned();
        is_test.then_some(Self { path, folder, time: Duration::ZERO, reached: BTreeSet::new() })
    }

    /// What it takes and reaches.
    fn without_mutant(&mut self) -> Result<()> {
        let list = self.path.with_extension("reached.txt");
        let begun = Instant::now();
        let limit = Duration::from_secs(3600);
        let ended = self.run(limit, &[("CANVASS_MUTANTS_REACHED", &list.to_string_lossy())])?;
        ensure!(ended == Ended::Passed, "{} without a mutant: {ended:?}", self.path.display());
        self.time = begun.elapsed();
        let lines = std::fs::read_to_string(&list).unwrap_or_default();
        self.reached = lines.lines().filter_map(|line| line.parse().ok()).collect();
        Ok(())
    }

    fn run(&self, limit: Duration, environment: &[(&str, &str)]) -> Result<Ended> {
        let shell = format!("ulimit -v {MEMORY} && ulimit -t {} && exec \"$0\" \"$@\"", limit.as_secs().max(1));
        let mut child = Command::new("sh")
            .args(["-c", &shell])
            .arg(&self.path)
            .arg("--test-threads=1")
            .envs(environment.iter().copied())
            // As cargo sets it, for tests that read files.
            .env("CARGO_MANIFEST_DIR", &self.folder)
            .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "true")
            .env("RUST_BACKTRACE", "0")
            .current_dir(&self.folder)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .with_context(|| self.path.display().to_string())?;
        let failed = first_failure(&mut child);
        if let Some(test) = failed {
            // One is enough.
            let _ = child.kill();
            child.wait()?;
            return Ok(Ended::Failed(test));
        }
        let status = child.wait()?;
        Ok(match std::os::unix::process::ExitStatusExt::signal(&status) {
            // The limit of processor time.
            Some(9 | 24) => Ended::Late,
            Some(signal) => Ended::Failed(format!("ended by signal {signal}")),
            None if status.success() => Ended::Passed,
            None => Ended::Failed(format!("{status}")),
        })
    }
}

/// How a program with tests came to its end.
#[derive(PartialEq, Eq, Debug)]
enum Ended {
    Passed,
    Failed(String),
    Late,
}

fn first_failure(child: &mut Child) -> Option<String> {
    let lines = BufReader::new(child.stdout.take()?).lines();
    lines.map_while(Result::ok).find_map(|line| {
        let name = line.strip_prefix("test ")?.strip_suffix("... FAILED")?;
        Some(name.trim().to_owned())
    })
}
