//! The products of cargo for Windows.

use super::{TARGET, plain_path};
use crate::compiled::compile;
use anyhow::Result;

/// The program, which is built with its tests.
pub const PROGRAM: &str = "target/x86_64-pc-windows-gnu/debug/canvass.exe";

/// The test programs to run: the tests of the program, and the tests of the buses, which use the system directly.
const TESTS: [&str; 11] = [
    "--package",
    "canvass",
    "--package",
    "canvass-bus",
    "--bin",
    "canvass",
    "--lib",
    "--test",
    "program",
    "--test",
    "pcan",
];

/// Builds the tests, and the program with them; returns the paths of the tests.
///
/// # Errors
/// If the build fails, or the compiler warns of anything in this workspace.
pub fn tests() -> Result<Vec<String>> {
    let args = [&["test", "--no-run", "--locked", "--target", TARGET], &TESTS[..]].concat();
    let built = compile(&mut plain_path::cargo()?.command, &args)?.without_warnings()?;
    Ok(built.tests.into_iter().map(|file| file.to_string_lossy().into_owned()).collect())
}

/// Checks all code by the compiler, without generating or linking machine code.
///
/// # Errors
/// If the code can't be compiled, or the compiler warns of anything in this workspace.
pub fn check() -> Result<()> {
    let args = [&["check", "--profile", "test", "--locked", "--target", TARGET], &TESTS[..]].concat();
    compile(&mut plain_path::cargo()?.command, &args)?.without_warnings()?;
    Ok(())
}
