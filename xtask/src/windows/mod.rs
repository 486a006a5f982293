//! `cargo xtask windows`: the program for Windows, built without a warning, and its tests as programs of Windows, by
//! Wine.

mod built;
mod ctrl_c;
mod left_out;
mod null_modem;
mod plain_path;
pub mod wine;

use crate::packages::{self, Package};
use crate::target;
use anyhow::{Result, ensure};

pub use plain_path::cargo;

/// The target of MinGW, as the compilers of Windows are not available here.
pub const TARGET: &str = "x86_64-pc-windows-gnu";
/// The C parts (zstd, lz4) need a compiler for this target, and Rust needs the compiler's linker.
pub const COMPILER: Package =
    Package { program: "x86_64-w64-mingw32-gcc", probe: &["--version"], package: "gcc-mingw-w64-x86-64" };
/// Wine of 64 bits: Wine of 32 bits is only recommended, and not needed.
pub const WINE: Package = Package { program: "wine", probe: &["--version"], package: "wine" };

/// Builds the program, and runs all its tests that need no Unix.
///
/// # Errors
/// If a tool is missing, the compiler warns, or a test fails.
pub fn test() -> Result<()> {
    packages::install(&[WINE])?;
    install_compiler()?;
    let tests = built::tests()?;
    let prefix = wine::Prefix::make()?;
    let left_out = left_out::read("tests/program")?;
    let mut counts = wine::Counts::default();
    for test in &tests {
        counts.add(prefix.run(test)?);
    }
    ctrl_c::press(&prefix, built::PROGRAM)?;
    eprintln!("{} tests ran as programs of Windows: {} passed, {} failed", counts.ran(), counts.passed, counts.failed);
    eprintln!(
        "{} tests of tests/program were left out:",
        left_out.iter().map(|group| group.tests.len()).sum::<usize>()
    );
    left_out.iter().for_each(|group| eprintln!("  {}: {}", group.reason, group.tests.join(", ")));
    ensure!(counts.failed == 0, "{} tests failed on Windows", counts.failed);
    Ok(())
}

/// Installs the compiler for Windows.
///
/// # Errors
/// If it can't be installed.
pub fn install_compiler() -> Result<()> {
    packages::install(&[COMPILER])?;
    target::add(TARGET)
}

/// The step of CI: all code compiles without warnings. If a tool is missing and can't be installed, the step is left
/// out with a message. [`test()`] also links the code and runs its tests: nightly, because that takes a quarter of an
/// hour.
///
/// # Errors
/// If the compiler warns, or the code can't be compiled.
pub fn step() -> Result<()> {
    if let Err(missing) = install_compiler() {
        eprintln!("LEFT OUT: nothing was compiled for Windows, because {missing:#}");
        return Ok(());
    }
    built::check()?;
    eprintln!("compiled for Windows without a warning (cargo xtask windows builds it and runs its tests)");
    Ok(())
}
