//! `cargo xtask windows`: the program for Windows, built without a warning, and its tests as programs of Windows, by Wine.

mod built;
mod ctrl_c;
mod left_out;
mod null_modem;
mod wine;

use crate::packages::{self, Package};
use crate::target;
use anyhow::{Result, ensure};

/// By MinGW, as the compilers of Windows are not to be had here.
pub const TARGET: &str = "x86_64-pc-windows-gnu";
/// The C parts (zstd, lz4) need a compiler for that target, and Rust its linker.
pub const COMPILER: Package =
    Package { program: "x86_64-w64-mingw32-gcc", probe: &["--version"], package: "gcc-mingw-w64-x86-64" };
/// Of 64 bits: that of 32 is only recommended, and not needed.
const WINE: Package = Package { program: "wine", probe: &["--version"], package: "wine" };

/// Those that take minutes by Wine, as they begin hundreds of programs. CI, which runs them on Linux, leaves them out here.
const LONG: [&str; 3] = ["killed::", "eds_from_device::", "eds_verify::"];

/// Builds, and runs all tests of the program that need no Unix.
///
/// # Errors
/// If something is missing for that, the compiler warns, or a test fails.
pub fn test() -> Result<()> {
    test_but(&[])
}

/// The same without tests whose names hold one of the words.
fn test_but(words: &[&str]) -> Result<()> {
    packages::install(&[COMPILER, WINE])?;
    target::add(TARGET)?;
    let tests = built::tests()?;
    let prefix = wine::Prefix::make()?;
    let left_out = left_out::read("tests/program")?;
    let mut counts = wine::Counts::default();
    for test in &tests {
        counts.add(prefix.run(test, words)?);
    }
    ctrl_c::press(&prefix, built::PROGRAM)?;
    eprintln!("{} tests ran as programs of Windows: {} passed, {} failed", counts.ran(), counts.passed, counts.failed);
    if !words.is_empty() {
        eprintln!("LEFT OUT, as they take long: {} (cargo xtask windows runs them)", words.join(", "));
    }
    eprintln!(
        "{} tests of tests/program were left out:",
        left_out.iter().map(|group| group.tests.len()).sum::<usize>()
    );
    left_out.iter().for_each(|group| eprintln!("  {}: {}", group.reason, group.tests.join(", ")));
    ensure!(counts.failed == 0, "{} tests failed on Windows", counts.failed);
    Ok(())
}

/// The step of CI: where something is missing that can't be had, it is left out, and said so.
///
/// # Errors
/// As [`test`].
pub fn step() -> Result<()> {
    let had = packages::install(&[COMPILER, WINE]).and_then(|()| target::add(TARGET));
    let Err(missing) = had else { return test_but(&LONG) };
    eprintln!("LEFT OUT: nothing was built for Windows, because {missing:#}");
    Ok(())
}
