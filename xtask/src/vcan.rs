//! `cargo xtask vcan [WORDS...]`: the tests on real SocketCAN, or those whose names hold one of the words, on this kernel if
//! it has vcan, else on Debian's in QEMU; with `--without-nightly` those of CI. `cargo xtask vcan-load`: a minute of the highest load, measured there.
//! `cargo xtask flaky --bus vcan` runs in the same machines.

mod deal;
mod files;
mod kernel;
mod machine;
mod report;

use crate::compiled::compile;
use crate::packages::{Package, install};
use crate::peers;
use crate::run::{is_there, this_program};
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Where Debian's kernel and the way into it are.
const FOLDER: &str = "target/vcan";
const PROBE: &str = "canvassprobe";
/// The test that `vcan-load` runs for a minute, and for how many seconds, as the test reads it.
const LOAD: &str = "load::nothing_is_lost";
const MINUTE: (&str, &str) = ("CANVASS_LOAD_SECONDS", "60");

const IPROUTE: Package = Package { program: "ip", probe: &["-V"], package: "iproute2" };

/// A minute of the highest load takes a third of that.
const FOR_TESTS: Duration = Duration::from_secs(1_800);
/// Runs on a machine that is busy all the time take three times as long as they say, and more where others work beside.
const FOR_RUNS: Duration = Duration::from_secs(4 * 3_600);

/// What CI leaves to the night: models whose verdicts show nothing of SocketCAN that the other four models do not.
const AT_NIGHT: [&str; 7] = [
    "verdicts::kuebler_c100",
    "verdicts::kuebler_d125",
    "verdicts::kuebler_sendix_f58",
    "verdicts::kuebler_sendix_f58m",
    "verdicts::kuebler_sendix_m58",
    "verdicts::reference_406",
    "verdicts::tr_lmp30",
];

/// The packages that other tests optimise less.
const OPTIMISED: [&str; 7] = ["analyzer", "bus", "device", "fuzzer", "reports", "suite", "traces"];

/// What a machine starts.
struct Job {
    /// The program.
    program: PathBuf,
    /// What is started again and again: the tests.
    starts: PathBuf,
    /// Its arguments before and after a test's name.
    arguments: [String; 2],
    /// Whether that needs other people's programs, and Python.
    needs_peers: bool,
    /// A machine that has said nothing for this long is given up.
    patience: Duration,
}

/// Runs the tests of `tests/vcan` but those that CI leaves to the night.
pub fn by_day() -> Result<()> {
    let job = prepare()?;
    let mut names = names(&job.starts)?;
    let all = names.len();
    names.retain(|name| !AT_NIGHT.contains(&name.as_str()));
    ensure!(names.len() + AT_NIGHT.len() == all, "tests on vcan that run at night have other names");
    run(&job, &names, &[])
}

/// Runs the tests of `tests/vcan` whose names hold one of the words, or all.
pub fn test(words: &[String]) -> Result<()> {
    if words == ["--without-nightly"] {
        return by_day();
    }
    let job = prepare()?;
    let mut names = names(&job.starts)?;
    names.retain(|name| words.is_empty() || words.iter().any(|word| name.contains(word)));
    ensure!(!names.is_empty(), "no test on vcan has a name with {}", words.join(" or "));
    run(&job, &names, &[])
}

/// Runs the test of the highest load for a minute.
pub fn load() -> Result<()> {
    run(&prepare()?, &[LOAD.to_owned()], &[MINUTE])
}

/// Runs this program with those arguments on so many machines with vcan, on each of them.
///
/// # Errors
/// If a machine can't be started, or the program fails.
pub fn on_machines(program: PathBuf, machines: u32, command: &str, arguments: &[String]) -> Result<()> {
    install(&[IPROUTE])?;
    let arguments = [String::new(), arguments.join(" ")];
    let job = Job { program, starts: this_program()?, arguments, needs_peers: false, patience: FOR_RUNS };
    machine::run(&job, &vec![command.to_owned(); machines as usize], &[]).context("in QEMU, as this kernel has no vcan")
}

fn prepare() -> Result<Job> {
    install_all()?;
    build()
}

/// Installs what the tests need, and QEMU where this kernel has no vcan.
///
/// # Errors
/// If something can't be had.
pub fn install_all() -> Result<()> {
    install(&[IPROUTE])?;
    peers::install_all()?;
    if has_vcan() { Ok(()) } else { machine::install_all() }
}

fn run(job: &Job, names: &[String], settings: &[(&str, &str)]) -> Result<()> {
    if has_vcan() {
        eprintln!("$ {} (this kernel has vcan)", job.starts.display());
        // They mostly wait.
        let mut tests = Command::new(&job.starts);
        tests.args(["--test-threads", "16", "--exact"]).args(names).envs(settings.iter().copied());
        let status = tests.status()?;
        ensure!(status.success(), "the tests on vcan ended with {status}");
        return Ok(());
    }
    machine::run(job, names, settings).context("the tests on vcan, in QEMU as this kernel has no vcan")
}

/// The program, optimised and with all checks of arithmetic.
pub fn program() -> Result<PathBuf> {
    Ok(build()?.program)
}

/// Builds the program and its tests.
fn build() -> Result<Job> {
    let mut cargo = Command::new("cargo");
    // An emulated processor is slow. What others wrote is optimised in any case, and need not be built once more.
    cargo.env("CARGO_PROFILE_DEV_OPT_LEVEL", "3");
    for package in OPTIMISED {
        cargo.args(["--config", &format!("profile.dev.package.canvass-{package}.opt-level=3")]);
    }
    let args = ["test", "--locked", "--features", "vcan", "--test", "vcan", "--no-run"];
    let tests = compile(&mut cargo, &args)?.tests.pop().context("cargo names no test to run")?;
    // The tests start the program that lies there.
    let program = tests.parent().and_then(Path::parent).context("the tests have no folder")?.join("canvass");
    let arguments = ["--test-threads 1 --nocapture --exact".to_owned(), String::new()];
    Ok(Job { program, starts: tests, arguments, needs_peers: true, patience: FOR_TESTS })
}

/// The names of all tests.
fn names(tests: &Path) -> Result<Vec<String>> {
    let output = Command::new(tests).args(["--list", "--format", "terse"]).output()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let names = text.lines().filter_map(|line| line.strip_suffix(": test"));
    let names: Vec<String> = names.map(str::to_owned).collect();
    if names.is_empty() {
        bail!("{} lists no test", tests.display());
    }
    Ok(names)
}

/// Whether a virtual CAN interface can be made here.
pub fn has_vcan() -> bool {
    let made = is_there("ip", &["link", "add", "dev", PROBE, "type", "vcan"]);
    made && is_there("ip", &["link", "del", PROBE])
}
