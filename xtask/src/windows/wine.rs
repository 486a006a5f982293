//! A separate Windows for the tests, made by Wine.

use super::COMPILER;
use super::null_modem::{self, NullModem};
use crate::run::run;
use anyhow::{Context, Result};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// The folder for files built for Wine.
pub const FOLDER: &str = "target/windows";
/// The source of a library with random numbers, as Rust requests them from Windows. Wine has this library from version
/// 9 on; Debian 12 has version 8.
const RANDOM: &str = "\
#include <windows.h>
#include <ntsecapi.h>
__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length) {
    return RtlGenRandom(data, (ULONG)length);
}
";
/// A stand-in for PEAK's library, with the functions that the tests need.
const PCAN: &str = "conformance/bus/tests/pcan/stand_in.c";

/// The folder that Wine uses as the disk of a Windows.
pub struct Prefix {
    folder: PathBuf,
    _ports: Option<NullModem>,
}

/// The numbers of passed and failed tests.
#[derive(Default)]
pub struct Counts {
    pub passed: usize,
    pub failed: usize,
}

impl Counts {
    pub fn ran(&self) -> usize {
        self.passed + self.failed
    }

    pub fn add(&mut self, other: Self) {
        (self.passed, self.failed) = (self.passed + other.passed, self.failed + other.failed);
    }

    /// The counts in a test's last line: `test result: ok. 31 passed; 0 failed; ...`.
    fn told(line: &str) -> Option<Self> {
        let counts = line.strip_prefix("test result: ")?.split_once(". ")?.1;
        let count = |what| counts.split("; ").find_map(|part| part.strip_suffix(what)?.trim().parse().ok());
        Some(Self { passed: count("passed")?, failed: count("failed")? })
    }
}

impl Prefix {
    /// Makes the Windows, with the libraries that the tests need.
    pub fn make() -> Result<Self> {
        let folder = std::env::current_dir()?.join(FOLDER);
        std::fs::create_dir_all(&folder)?;
        let mut prefix = Self { folder: folder.join("wine"), _ports: None };
        let system = prefix.folder.join("drive_c/windows/system32");
        // A Windows whose creation was interrupted lacks this file.
        if !system.join("kernel32.dll").exists() {
            eprintln!("$ wineboot");
            let made = prefix.wine(&["wineboot", "--init"]).status().context("wine")?;
            anyhow::ensure!(made.success(), "wineboot ended with {made}");
        }
        let source = folder.join("random.c");
        std::fs::write(&source, RANDOM)?;
        library(&source, &system.join("bcryptprimitives.dll"), &["-ladvapi32"])?;
        // The stand-in is not where programs find libraries: tests that need it set the path.
        library(Path::new(PCAN), &folder.join("PCANBasic.dll"), &["-lws2_32", "-lpthread"])?;
        prefix._ports = Some(NullModem::join(&prefix.folder)?);
        Ok(prefix)
    }

    /// A file on the disk of this Windows.
    pub fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// A program of Windows, or a name that Wine knows, with its arguments.
    pub fn wine(&self, args: &[&str]) -> Command {
        self.with_surroundings(Command::new("wine"), args)
    }

    /// A program of Windows on the terminal that is its standard input: Ctrl-C reaches only programs for which this is
    /// the controlling terminal.
    pub fn wine_on_terminal(&self, args: &[&str]) -> Command {
        let mut setsid = Command::new("setsid");
        setsid.args(["--ctty", "wine"]);
        self.with_surroundings(setsid, args)
    }

    fn with_surroundings(&self, mut wine: Command, args: &[&str]) -> Command {
        wine.args(args).env("WINEPREFIX", &self.folder).stdin(Stdio::null());
        // Wine reports no unimplemented functions and offers no installations; the library of [`RANDOM`] replaces
        // Wine's own.
        wine.env(null_modem::VARIABLE, null_modem::PORTS.join(","));
        wine.env("WINEDEBUG", "-all").env("WINEDLLOVERRIDES", "mscoree,mshtml=;bcryptprimitives=n,b");
        wine
    }

    /// Runs the tests in a file, and prints their output.
    pub fn run(&self, tests: &str) -> Result<Counts> {
        eprintln!("$ wine {tests}");
        let mut running = self.wine(&[tests]).stdout(Stdio::piped()).spawn().context("wine")?;
        let mut counts = None;
        for line in BufReader::new(running.stdout.take().context("wine")?).lines() {
            let line = line?;
            let line = line.trim_end();
            counts = counts.or(Counts::told(line));
            // Passed tests are not printed, as they are many.
            if !line.ends_with(" ... ok") {
                eprintln!("{line}");
            }
        }
        let status = running.wait()?;
        counts.with_context(|| format!("{tests} ended with {status} before its end"))
    }
}

impl Drop for Prefix {
    /// Ends the processes of Wine that would continue after the last program.
    fn drop(&mut self) {
        // If the command fails, Wine ends by itself.
        let _ = self.wine(&["wineboot", "--end-session", "--shutdown"]).stderr(Stdio::null()).status();
    }
}

fn library(source: &Path, file: &Path, more: &[&str]) -> Result<()> {
    let (source, file) = (source.display().to_string(), file.display().to_string());
    let args = ["-shared", "-static", "-O1", "-o", &file, &source];
    run(COMPILER.program, &[&args[..], more].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_line_of_tests_is_counted() {
        let told = Counts::told(
            "test result: FAILED. 31 passed; 2 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1s",
        );
        assert!(told.is_some_and(|counts| (counts.passed, counts.failed, counts.ran()) == (31, 2, 33)));
        assert!(Counts::told("test program::a ... ok").is_none());
    }
}
