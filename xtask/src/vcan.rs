//! `cargo xtask vcan [WORDS...]`: the tests on real SocketCAN, or those whose names hold one of the words, on this kernel if
//! it has vcan, else on Debian's in QEMU. `cargo xtask vcan-load`: a minute of the highest load, measured there.

mod deal;
mod files;
mod kernel;
mod machine;
mod report;

use crate::packages::{Package, install};
use crate::peers;
use crate::run::is_there;
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Where Debian's kernel and the way into it are.
const FOLDER: &str = "target/vcan";
const PROBE: &str = "canvassprobe";
/// The test that `vcan-load` runs for a minute, and for how many seconds, as the test reads it.
const LOAD: &str = "load::nothing_is_lost";
const MINUTE: (&str, &str) = ("CANVASS_LOAD_SECONDS", "60");

const IPROUTE: Package = Package { program: "ip", probe: &["-V"], package: "iproute2" };

/// The packages that other tests optimise less.
const OPTIMISED: [&str; 7] = ["analyzer", "bus", "device", "fuzzer", "reports", "suite", "traces"];

/// What was built.
struct Built {
    /// The program.
    program: PathBuf,
    /// The tests.
    tests: PathBuf,
}

/// Runs the tests of `tests/vcan` whose names hold one of the words, or all.
pub fn test(words: &[String]) -> Result<()> {
    let built = prepare()?;
    let mut names = names(&built.tests)?;
    names.retain(|name| words.is_empty() || words.iter().any(|word| name.contains(word)));
    ensure!(!names.is_empty(), "no test on vcan has a name with {}", words.join(" or "));
    run(&built, &names, &[])
}

/// Runs the test of the highest load for a minute.
pub fn load() -> Result<()> {
    run(&prepare()?, &[LOAD.to_owned()], &[MINUTE])
}

fn prepare() -> Result<Built> {
    install(&[IPROUTE])?;
    peers::install_all()?;
    build()
}

fn run(built: &Built, names: &[String], settings: &[(&str, &str)]) -> Result<()> {
    if has_vcan() {
        eprintln!("$ {} (this kernel has vcan)", built.tests.display());
        // They mostly wait.
        let mut tests = Command::new(&built.tests);
        tests.args(["--test-threads", "16", "--exact"]).args(names).envs(settings.iter().copied());
        let status = tests.status()?;
        ensure!(status.success(), "the tests on vcan ended with {status}");
        return Ok(());
    }
    machine::run(built, names, settings).context("the tests on vcan, in QEMU as this kernel has no vcan")
}

/// The program, optimised and with all checks of arithmetic.
pub fn program() -> Result<PathBuf> {
    Ok(build()?.program)
}

/// Builds the program and its tests.
fn build() -> Result<Built> {
    let args = [
        "test",
        "--locked",
        "--features",
        "vcan",
        "--test",
        "vcan",
        "--no-run",
        "--message-format",
        "json-render-diagnostics",
    ];
    eprintln!("$ cargo {}", args.join(" "));
    // An emulated processor is slow. What others wrote is optimised in any case, and need not be built once more.
    let optimised = ("CARGO_PROFILE_DEV_OPT_LEVEL", "3");
    let mut cargo = Command::new("cargo");
    for package in OPTIMISED {
        cargo.args(["--config", &format!("profile.dev.package.canvass-{package}.opt-level=3")]);
    }
    let output = cargo.args(args).env(optimised.0, optimised.1).stderr(Stdio::inherit()).output()?;
    ensure!(output.status.success(), "the tests could not be built: {}", output.status);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let mut executables = text.lines().filter_map(|line| line.split_once("\"executable\":\"")?.1.split('"').next());
    let is_test =
        |path: &&str| Path::new(path).file_name().is_some_and(|name| name.to_string_lossy().starts_with("vcan-"));
    let tests = executables.rfind(is_test).map(PathBuf::from).context("cargo names no test to run")?;
    // The tests start the program that lies there.
    let program = tests.parent().and_then(Path::parent).context("the tests have no folder")?.join("canvass");
    Ok(Built { program, tests })
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
