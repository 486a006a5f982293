//! The Python module: its tests, and the wheel.

use crate::compiled::FEATURES;
use crate::consent;
use crate::run::{run, target_folder};
use crate::venv::Venv;
use crate::{target, windows};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const VENV: Venv = Venv {
    folder: "target/python-venv",
    python: "target/python-venv/bin/python",
    requirements: "python/requirements.txt",
    probe: "import maturin, pytest, can, canopen, pyarrow, pandas, polars, duckdb, robot, nbclient",
};

/// The folder in which the tests find the module, as if it were installed.
const STAGE: &str = "target/python-dev";
/// The folder of the wheel's further files: the program.
const DATA: &str = "python/wheel.data/scripts";
/// The folder of the wheels.
const WHEELS: &str = "target/dist";

/// Installs what the tests need.
pub fn install() -> Result<()> {
    VENV.install()
}

/// Compiles the module with everything else, and runs its tests.
pub fn test() -> Result<()> {
    install()?;
    // With the tests, the features of all crates are those of the test step: nothing is compiled a second time.
    const BUILD: [&str; 6] = ["build", "--workspace", "--lib", "--bins", "--tests", "--locked"];
    run("cargo", &[&BUILD[..], &FEATURES[..]].concat())?;
    stage()?;
    let program = target_folder().join("debug/canvass").canonicalize().context("the compiled program")?;
    let tests = ["-m", "pytest", "-q", "--rootdir", "python", "python/tests"];
    eprintln!("$ {} {}", VENV.python, tests.join(" "));
    let mut command = Command::new(VENV.python);
    command.args(tests).env("PYTHONPATH", Path::new(STAGE).canonicalize()?).env("CANVASS_PROGRAM", program);
    let status = command.status().context(VENV.python)?;
    ensure!(status.success(), "the tests of the Python module ended with {status}");
    Ok(())
}

/// Lays out the compiled module as an installation does. The wheel itself is compiled for release, and checked by
/// `cargo xtask wheel`.
fn stage() -> Result<()> {
    let stage = Path::new(STAGE);
    if stage.exists() {
        fs::remove_dir_all(stage)?;
    }
    let module = stage.join("canvass");
    fs::create_dir_all(&module)?;
    for file in fs::read_dir("python/canvass")? {
        let file = file?.path();
        if let (true, Some(name)) = (file.is_file(), file.file_name()) {
            fs::copy(&file, module.join(name))?;
        }
    }
    let library = target_folder().join("debug/libcanvass_python.so");
    fs::copy(&library, module.join("_native.abi3.so")).with_context(|| library.display().to_string())?;
    let version = env!("CARGO_PKG_VERSION");
    let info = stage.join(format!("canvass-{version}.dist-info"));
    fs::create_dir_all(&info)?;
    fs::write(info.join("METADATA"), format!("Metadata-Version: 2.1\nName: canvass\nVersion: {version}\n"))?;
    fs::write(info.join("entry_points.txt"), entry_points()?)?;
    Ok(())
}

/// The entry points of `pyproject.toml`, in the form of an installed package.
fn entry_points() -> Result<String> {
    let project = fs::read_to_string("python/pyproject.toml")?;
    let mut text = String::new();
    for section in project.split("\n[").filter_map(|section| section.strip_prefix("project.entry-points.")) {
        let (name, entries) = section.split_once("]\n").context("a section of pyproject.toml")?;
        let entries = entries.replace('"', "");
        text.push_str(&format!("[{}]\n{}\n", name.trim_matches('"'), entries.trim_end()));
    }
    ensure!(text.contains("canvass.can"), "pyproject.toml names no entry points");
    Ok(text)
}

/// Makes the wheels, for this system and for Windows, and checks the first one in a clean environment.
pub fn wheel() -> Result<()> {
    install()?;
    for made in wheels()? {
        eprintln!("{}: {} bytes", made.display(), fs::metadata(&made)?.len());
    }
    check()
}

/// Makes the wheels; the second one only if this machine has a compiler for Windows.
pub fn wheels() -> Result<Vec<PathBuf>> {
    install()?;
    fs::create_dir_all(WHEELS)?;
    let mut made = vec![build(None)?];
    match windows::install_compiler().and_then(|()| target::add(windows::TARGET)) {
        Ok(()) => made.push(build(Some(windows::TARGET))?),
        Err(missing) => eprintln!("the wheel for Windows was left out: {missing:#}"),
    }
    Ok(made)
}

/// Makes the wheel of a target: the program first, then the module with the program beside it.
fn build(target: Option<&str>) -> Result<PathBuf> {
    let of_target = target.map_or(Vec::new(), |target| vec!["--target", target]);
    run("cargo", &[&["build", "--release", "--locked", "--bin", "canvass"], &of_target[..]].concat())?;
    let name = if target.is_some_and(|target| target.contains("windows")) { "canvass.exe" } else { "canvass" };
    let program = target_folder().join(target.unwrap_or_default()).join("release").join(name);
    if Path::new(DATA).exists() {
        fs::remove_dir_all(DATA)?;
    }
    fs::create_dir_all(DATA)?;
    fs::copy(&program, Path::new(DATA).join(name)).with_context(|| program.display().to_string())?;
    let before = all_wheels()?;
    let mut maturin = vec!["-m", "maturin", "build", "--release", "--locked", "--out", WHEELS];
    maturin.extend(["--manifest-path", "python/Cargo.toml"]);
    if target.is_some() {
        // One module serves all versions from 3.9 on; without a name maturin would try those that can't have it, too.
        maturin.extend(["--interpreter", "python3.9"]);
    }
    maturin.extend(of_target);
    run(VENV.python, &maturin)?;
    fs::remove_dir_all(DATA)?;
    let platform = if name.ends_with(".exe") { "win" } else { "linux" };
    let made = all_wheels()?.into_iter().filter(|path| path.to_string_lossy().contains(platform));
    let newest =
        made.max_by_key(|path| (!before.contains(path), fs::metadata(path).and_then(|data| data.modified()).ok()));
    newest.context("maturin has made no wheel")
}

fn all_wheels() -> Result<Vec<PathBuf>> {
    let entries = fs::read_dir(WHEELS)?.map(|entry| entry.map(|entry| entry.path()));
    let paths = entries.collect::<std::io::Result<Vec<_>>>()?;
    Ok(paths.into_iter().filter(|path| path.extension().is_some_and(|extension| extension == "whl")).collect())
}

/// Installs the wheel into a clean environment without an index, and uses each of its parts.
///
/// # Errors
/// If a part does not work.
pub fn check() -> Result<()> {
    const CLEAN: &str = "target/python-clean";
    const PYTHON: &str = "target/python-clean/bin/python";
    consent::ask(&format!("a clean Python environment in {CLEAN}"), "python3 -m venv")?;
    run("python3", &["-m", "venv", "--clear", CLEAN])?;
    let wheel = all_wheels()?.into_iter().filter(|path| path.to_string_lossy().contains("linux")).max();
    let wheel = wheel.context("there is no wheel")?;
    run(PYTHON, &["-m", "pip", "install", "--quiet", "--no-index", &wheel.to_string_lossy()])?;
    run("target/python-clean/bin/canvass", &["test", "sim:reference-301", "--select", "301/boot-up"])?;
    // Nothing but the wheel: the module works without any other package.
    run(PYTHON, &["-c", "import canvass; assert canvass.test('sim:reference-301', select='301/boot-up').passed"])?;
    run(PYTHON, &["-c", "import canvass; assert len(list(canvass.read('docs/examples/commissioning.log'))) == 39"])?;
    // The tests with the other packages, on the installed module.
    run(PYTHON, &["-m", "pip", "install", "--quiet", "--requirement", "python/requirements.txt"])?;
    run(PYTHON, &["-m", "pytest", "-q", "--rootdir", "python", "python/tests"])
}
