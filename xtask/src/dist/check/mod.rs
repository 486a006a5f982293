//! `cargo xtask dist --check`: each package is installed in a clean place, run and removed.

pub mod archives;
pub mod components;
pub mod container;
pub mod debian;
pub mod editor;
pub mod manifests;
pub mod npm;
pub mod pipelines;
pub mod registries;
pub mod rpm;
pub mod windows_installer;

use super::{FOLDER, Part, VERSION, files};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A capture that each installed program decodes, and what its first line begins with.
pub const SAMPLE: &str = "traces/samples/kuebler-5.7.7.txt";
const DECODED: &str = "0.000000  can0  73F  00                       63  boot-up     boot-up";
/// Cases that each installed program runs on a simulated device.
const TEST: [&str; 4] = ["test", "sim:kuebler-sendix-58x8", "--select", "301/sdo/upload"];

/// Checks these parts, and prints a row of a table for each.
///
/// # Errors
/// If a part does not do what it should; the others are checked before.
pub fn all(parts: &[&'static Part]) -> Result<()> {
    let mut failures = Vec::new();
    println!("| package | bytes | checked |\n|---|---|---|");
    for part in parts {
        let checked = (part.check)();
        let did = match &checked {
            Ok(did) => did.clone(),
            Err(error) => format!("FAILED: {error:#}"),
        };
        let files = files(part.id).unwrap_or_default();
        if files.is_empty() {
            println!("| {} | | {did} |", part.name);
        }
        for file in files {
            let bytes = fs::metadata(&file).map(|data| data.len()).unwrap_or_default();
            println!("| `{}` | {bytes} | {did} |", file.file_name().unwrap_or_default().to_string_lossy());
        }
        if checked.is_err() {
            failures.push(format!("{}: {did}", part.name));
        }
    }
    ensure!(failures.is_empty(), "{}", failures.join("\n"));
    Ok(())
}

/// Lets an installed program say its version, decode a capture and test a device. `program` makes a call of it; `sample`
/// is where it finds the capture.
fn exercise(program: &dyn Fn(&[&str]) -> Command, sample: &str) -> Result<()> {
    let told = output(&mut program(&["--version"]))?;
    ensure!(told.trim() == format!("canvass {VERSION}"), "expected canvass {VERSION}, found {told:?}");
    let decoded = output(&mut program(&["decode", sample]))?;
    let first = decoded.lines().next().unwrap_or_default().trim_end();
    ensure!(first == DECODED, "decode: expected {DECODED:?}, found {first:?}");
    let tested = output(&mut program(&TEST))?;
    ensure!(tested.contains("cases none failed"), "test: expected that no case fails, found {tested}");
    Ok(())
}

/// The standard output of a program that has to end with status 0.
fn output(command: &mut Command) -> Result<String> {
    eprintln!("$ {command:?}");
    let output = command.output().with_context(|| format!("{command:?}"))?;
    let (out, error) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    ensure!(output.status.success(), "{command:?} ended with {}: {out}{error}", output.status);
    Ok(out.into_owned())
}

/// Runs a program that has to end with status 0, with nothing of this project in its surroundings.
fn bare(program: impl AsRef<std::ffi::OsStr>) -> Command {
    let mut command = Command::new(program);
    command.env_clear().env("PATH", "/usr/sbin:/usr/bin:/sbin:/bin").env("LANG", "C.UTF-8");
    command
}

/// A program in a folder that is the root of its file system.
fn inside(root: &Path, words: &[&str]) -> Command {
    let mut chroot = bare("chroot");
    chroot.arg(root).args(words);
    chroot
}

/// An empty folder to install into.
fn clean(name: &str) -> Result<PathBuf> {
    let folder = std::env::current_dir()?.join(FOLDER).join("check").join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder)?;
    Ok(folder)
}

/// Puts the capture into a folder that an installed program sees as its root; returns its path there.
fn sample_in(root: &Path) -> Result<&'static str> {
    fs::copy(SAMPLE, root.join("capture.txt"))?;
    Ok("/capture.txt")
}

/// An absolute path, for programs that run elsewhere.
fn absolute(path: &Path) -> Result<String> {
    Ok(path.canonicalize().with_context(|| path.display().to_string())?.to_string_lossy().into_owned())
}
