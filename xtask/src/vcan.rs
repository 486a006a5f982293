//! `cargo xtask vcan [WORDS...]`: the tests on real SocketCAN, or those whose names contain one of the words; with
//! `--without-nightly` the tests of CI. They run on this kernel if it has vcan, else on Debian's kernel in QEMU. `cargo
//! xtask vcan-load`: measures a minute of the highest load on the same kernel. `cargo xtask flaky --bus vcan` runs in
//! the same machines.

mod deal;
mod files;
mod kernel;
mod machine;
mod report;

use crate::compiled::{FEATURES, compile};
use crate::packages::{Package, install};
use crate::peers;
use crate::run::{is_there, this_program};
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// The folder for Debian's kernel and the archives for its machines.
const FOLDER: &str = "target/vcan";
const PROBE: &str = "canvassprobe";
/// The test that `vcan-load` runs for a minute.
const LOAD: &str = "load::nothing_is_lost";
/// The variable for the duration of the test [`LOAD`], and a minute in seconds.
const MINUTE: (&str, &str) = ("CANVASS_LOAD_SECONDS", "60");

const IPROUTE: Package = Package { program: "ip", probe: &["-V"], package: "iproute2" };

/// Time without output after which a machine with tests is ended. A minute of the highest load takes a third of this
/// time.
const FOR_TESTS: Duration = Duration::from_secs(1_800);
/// Time without output after which a machine with runs of `flaky` is ended. On a busy machine a run takes three times
/// as long as on an idle one, and longer if the computer has other work.
const FOR_RUNS: Duration = Duration::from_secs(4 * 3_600);

/// The tests that CI leaves to the night, the longest ones. The verdicts of these models show nothing of SocketCAN that
/// the other model does not show. Tests on the simulated bus kill runs at many more moments, and run the suite and the
/// fuzzer on the same traits.
const AT_NIGHT: [&str; 19] = [
    "fuzzing::python_canopen_as_device",
    "killed::the_journal_of_a_killed_run_puts_the_device_back",
    "load::nothing_is_lost",
    "traits::keeps_ram_over_reset",
    "traits::loses_its_node_id",
    "traits::pdos_off",
    "traits::refuses_while_valid",
    "traits::restarts_in_5_s",
    "verdicts::dirty_padding_changes_no_verdict",
    "verdicts::kuebler_c100",
    "verdicts::kuebler_d125",
    "verdicts::kuebler_sendix_58x8",
    "verdicts::kuebler_sendix_f58",
    "verdicts::kuebler_sendix_f58m",
    "verdicts::kuebler_sendix_m58",
    "verdicts::lika_ax58",
    "verdicts::reference_406",
    "verdicts::tr_c65",
    "verdicts::tr_lmp30",
];

/// The work of a machine.
struct Job {
    /// The program under test.
    program: PathBuf,
    /// The program that is started: the tests on vcan, or this program itself in [`on_machines`].
    starts: PathBuf,
    /// The arguments of `starts` before and after a test's name.
    arguments: [String; 2],
    /// Whether the tests need other people's programs, and Python.
    needs_peers: bool,
    /// Time without output after which a machine is ended.
    patience: Duration,
}

/// Runs the tests of `tests/vcan`, except the tests that CI leaves to the night.
pub fn by_day() -> Result<()> {
    let job = prepare()?;
    let mut names = names(&job.starts)?;
    let all = names.len();
    names.retain(|name| !AT_NIGHT.contains(&name.as_str()));
    ensure!(names.len() + AT_NIGHT.len() == all, "tests on vcan that run at night have other names");
    run(&job, &names, &[])
}

/// Runs the tests of `tests/vcan` whose names contain one of the words, or all.
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

/// Runs this program with these arguments on each of `machines` machines with vcan.
///
/// # Errors
/// If a machine can't be started, or the program fails.
pub fn on_machines(program: PathBuf, machines: u32, command: &str, arguments: &[String]) -> Result<()> {
    install(&[IPROUTE])?;
    let arguments = [String::new(), arguments.join(" ")];
    let job = Job { program, starts: this_program()?, arguments, needs_peers: false, patience: FOR_RUNS };
    machine::run(&job, &vec![command.to_owned(); machines as usize], &[])
        .context("the run in QEMU failed (this kernel has no vcan)")
}

fn prepare() -> Result<Job> {
    install_all()?;
    build()
}

/// Installs the programs for the tests, and QEMU if this kernel has no vcan.
///
/// # Errors
/// If a program can't be installed.
pub fn install_all() -> Result<()> {
    install(&[IPROUTE])?;
    peers::install_all()?;
    if has_vcan() { Ok(()) } else { machine::install_all() }
}

fn run(job: &Job, names: &[String], settings: &[(&str, &str)]) -> Result<()> {
    if has_vcan() {
        eprintln!("$ {} (this kernel has vcan)", job.starts.display());
        // More threads than processors, as the tests mostly wait.
        let mut tests = Command::new(&job.starts);
        tests.args(["--test-threads", "16", "--exact"]).args(names).envs(settings.iter().copied());
        let status = tests.status()?;
        ensure!(status.success(), "the tests on vcan ended with {status}");
        return Ok(());
    }
    machine::run(job, names, settings).context("the tests on vcan, in QEMU as this kernel has no vcan")
}

/// Builds the program and its tests. The features are those of CI's tests, so that nothing is compiled twice.
fn build() -> Result<Job> {
    let args = [&["test", "--workspace", "--locked", "--test", "vcan", "--no-run"], &FEATURES[..]].concat();
    let tests = compile(&mut Command::new("cargo"), &args)?.tests.pop().context("cargo names no test to run")?;
    // The tests start the program in this folder.
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
