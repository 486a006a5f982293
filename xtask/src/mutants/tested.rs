//! Runs a crate's own tests on its mutants, each test in a process of its own that may crash or never end.
//!
//! Each test first runs alone without a mutant, which records its duration and the places that it reaches. A mutant
//! then needs only the tests that reach its place; they run in the order of their duration until one fails.

use super::area::Area;
use super::drawn::Mutant;
use super::{parallel, scratch};
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Limit of memory in KiB: a mutant that fills its memory ends.
const MEMORY: u64 = 4_000_000;
/// Maximum processor time of a test on a mutant, as a multiple of the time that the test takes without a mutant.
const SLOWER: u32 = 10;
/// Seconds that a test on a mutant may take in addition to [`SLOWER`] times its usual time.
const BESIDES: u64 = 5;

/// The result of the tests on a mutant.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum Outcome {
    /// This test failed.
    Caught(String),
    /// This test did not end within its time.
    Hung(String),
    /// All tests passed.
    Missed,
    /// No test reaches the mutant's place.
    Unreached,
}

/// A mutant with its result.
pub struct Fate {
    pub mutant: Mutant,
    pub outcome: Outcome,
}

/// A program with tests.
struct Program {
    path: PathBuf,
    /// The folder of the program's crate.
    folder: PathBuf,
}

/// A test, with its behaviour without a mutant.
struct Test<'a> {
    program: &'a Program,
    name: String,
    time: Duration,
    /// The places that the test reaches.
    reached: BTreeSet<u32>,
}

/// The test programs of a mutated crate.
pub struct Programs(Vec<Program>);

/// The tests of all programs, the quickest first.
pub struct Tests<'a>(Vec<Test<'a>>);

impl Programs {
    /// Builds the test programs.
    pub fn build(area: &Area) -> Result<Self> {
        eprintln!("building the tests with all mutants");
        let format = "--message-format=json-render-diagnostics";
        let arguments = ["test", "--no-run", "--profile", "mutants", "--package", area.package, format];
        let output =
            scratch::cargo(area, &arguments).stderr(Stdio::inherit()).output().context("cargo test --no-run")?;
        ensure!(output.status.success(), "the mutated tests do not build: {}", output.status);
        let lines = String::from_utf8_lossy(&output.stdout).into_owned();
        let programs = lines.lines().filter_map(Program::named).collect::<Vec<_>>();
        ensure!(!programs.is_empty(), "{} has no tests", area.package);
        Ok(Self(programs))
    }

    /// Runs each test without a mutant. Tests that take more than `within` seconds of a processor are left out.
    pub fn tests(&self, within: Option<u64>) -> Result<Tests<'_>> {
        let mut named = Vec::new();
        for program in &self.0 {
            named.extend(program.names()?.into_iter().map(|name| (program, name)));
        }
        eprintln!("running {} tests without a mutant, to learn their duration and the places they reach", named.len());
        let limit = Duration::from_secs(within.unwrap_or(3600));
        let tests = parallel::each(&named, 200, |(program, name)| Test::measured(program, name, limit))?;
        let mut tests: Vec<Test<'_>> = tests.into_iter().flatten().collect();
        ensure!(within.is_some() || tests.len() == named.len(), "a test without a mutant comes to no end");
        tests.sort_by_key(|test| test.time);
        Ok(Tests(tests))
    }
}

impl Tests<'_> {
    pub const fn count(&self) -> usize {
        self.0.len()
    }

    /// The total duration of the tests without a mutant.
    pub fn time(&self) -> Duration {
        self.0.iter().map(|test| test.time).sum()
    }

    /// Runs the tests on all mutants.
    pub fn all(&self, mutants: &[Mutant]) -> Result<Vec<Fate>> {
        parallel::each(mutants, 50, |mutant| Ok(Fate { mutant: mutant.clone(), outcome: self.one(mutant)? }))
    }

    fn one(&self, mutant: &Mutant) -> Result<Outcome> {
        let mut outcome = Outcome::Unreached;
        for test in self.0.iter().filter(|test| test.reached.contains(&mutant.place)) {
            match test.with_mutant(mutant)? {
                Ended::Passed => outcome = Outcome::Missed,
                Ended::Failed => return Ok(Outcome::Caught(test.name.clone())),
                Ended::Late => return Ok(Outcome::Hung(test.name.clone())),
            }
        }
        Ok(outcome)
    }
}

impl<'a> Test<'a> {
    /// Measures a test without a mutant; `None` if it exceeds the limit.
    fn measured(program: &'a Program, name: &str, limit: Duration) -> Result<Option<Self>> {
        let list = program.path.with_extension(format!("{}.reached", name.replace("::", "-")));
        let begun = Instant::now();
        let ended = program.run(name, limit, ("CANVASS_MUTANTS_REACHED", &list.to_string_lossy()))?;
        ensure!(ended != Ended::Failed, "{name} fails without a mutant");
        let time = begun.elapsed();
        // A test that reaches no place writes no file.
        let lines = std::fs::read_to_string(&list).unwrap_or_default();
        let _ = std::fs::remove_file(&list);
        let reached = lines.lines().filter_map(|line| line.parse().ok()).collect();
        let test = Self { program, name: name.to_owned(), time, reached };
        Ok((ended == Ended::Passed).then_some(test))
    }

    fn with_mutant(&self, mutant: &Mutant) -> Result<Ended> {
        let limit = self.time * SLOWER + Duration::from_secs(BESIDES);
        self.program.run(&self.name, limit, ("CANVASS_MUTANT", &mutant.number.to_string()))
    }
}

impl Program {
    /// The program in a message of cargo, if it contains tests.
    fn named(line: &str) -> Option<Self> {
        let message: Value = serde_json::from_str(line).ok()?;
        let is_test = message.get("profile")?.get("test")?.as_bool()?;
        let path = PathBuf::from(message.get("executable")?.as_str()?);
        let folder = Path::new(message.get("manifest_path")?.as_str()?).parent()?.to_owned();
        is_test.then_some(Self { path, folder })
    }

    /// The names of the program's tests.
    fn names(&self) -> Result<Vec<String>> {
        let output = Command::new(&self.path).args(["--list", "--format", "terse"]).output();
        let output = output.with_context(|| self.path.display().to_string())?;
        let lines = String::from_utf8_lossy(&output.stdout).into_owned();
        Ok(lines.lines().filter_map(|line| line.strip_suffix(": test")).map(str::to_owned).collect())
    }

    /// Runs one test, with a variable in the environment.
    fn run(&self, test: &str, limit: Duration, variable: (&str, &str)) -> Result<Ended> {
        let shell = format!("ulimit -v {MEMORY} && ulimit -t {} && exec \"$0\" \"$@\"", limit.as_secs().max(1));
        let status = Command::new("sh")
            .args(["-c", &shell])
            .arg(&self.path)
            .args(["--test-threads=1", "--exact", test])
            .env(variable.0, variable.1)
            // Cargo sets this variable for tests that read files.
            .env("CARGO_MANIFEST_DIR", &self.folder)
            .env("PROPTEST_DISABLE_FAILURE_PERSISTENCE", "true")
            .env("RUST_BACKTRACE", "0")
            .current_dir(&self.folder)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .with_context(|| self.path.display().to_string())?;
        Ok(match std::os::unix::process::ExitStatusExt::signal(&status) {
            // The signals of the limit of processor time.
            Some(9 | 24) => Ended::Late,
            None if status.success() => Ended::Passed,
            _ => Ended::Failed,
        })
    }
}

/// The end of a test's run.
#[derive(PartialEq, Eq, Debug)]
enum Ended {
    Passed,
    Failed,
    Late,
}
