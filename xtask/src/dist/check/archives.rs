//! The archives: unpacked into an empty folder, and run from there.

use super::{SAMPLE, absolute, bare, clean, exercise, output};
use crate::dist::{file, files, name, system};
use crate::packages;
use crate::windows::{self, wine};
use anyhow::{Result, ensure};
use std::process::Command;

/// The programs for Linux, with nothing in their environment; that of another processor by an emulator.
pub fn linux() -> Result<String> {
    for system in system::LINUX {
        let folder = clean("archive")?;
        output(bare("tar").arg("-xzf").arg(file("linux", system.target)?).arg("-C").arg(&folder))?;
        let folder = folder.join(name(system.target));
        for beside in ["README.md", "man/canvass-test.1", "completions/_canvass"] {
            ensure!(folder.join(beside).exists(), "{beside} is missing in {}", folder.display());
        }
        exercise(&|words| runner(system, &folder.join("canvass"), words), &absolute(SAMPLE.as_ref())?)?;
    }
    Ok("unpacked, run".to_owned())
}

/// A program of a system, on this machine.
pub fn runner(system: &system::System, program: &std::path::Path, words: &[&str]) -> Command {
    let mut command = match &system.emulator {
        None => bare(program),
        Some(emulator) => {
            let mut command = bare(emulator.program);
            command.arg(program);
            command
        }
    };
    command.args(words);
    command
}

/// Installs the emulators of other processors.
pub fn install_emulators() -> Result<()> {
    system::LINUX
        .iter()
        .filter_map(|system| system.emulator.as_ref())
        .try_for_each(|emulator| packages::install(&[packages::Package { ..*emulator }]))
}

/// The program for Windows, by Wine.
pub fn windows() -> Result<String> {
    let folder = clean("windows")?;
    output(bare("unzip").arg("-q").arg(file("windows", ".zip")?).arg("-d").arg(&folder))?;
    let program = folder.join(name(windows::TARGET)).join("canvass.exe");
    let program = program.to_string_lossy().into_owned();
    let prefix = wine::Prefix::make()?;
    exercise(&|words| prefix.wine(&[&[program.as_str()], words].concat()), SAMPLE)?;
    Ok("unpacked, run by Wine".to_owned())
}

/// The page: its file has everything in it.
pub fn page() -> Result<String> {
    for file in files("page")? {
        let bytes = std::fs::metadata(&file)?.len();
        ensure!(bytes > 1_000_000, "{} has {bytes} bytes", file.display());
    }
    Ok("shown in Chromium by `cargo xtask web-test`".to_owned())
}
