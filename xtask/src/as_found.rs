//! `cargo xtask as-found`: checks that canvass leaves devices as it found them, with python-canopen in virtual time
//! as the judge.

use crate::peers;
use crate::run::run;
use anyhow::Result;

/// The program of the simulated device, which the judge controls (built with canvass by `--bin lockstep`).
const LOCKSTEP: &str = "target/debug/lockstep";
const CANVASS: &str = "target/debug/canvass";
const JUDGE: &str = "tests/peers/as_found";

/// Runs the judge with its own options; it prints a table and the shortest run of each kind of difference.
///
/// # Errors
/// If a device differs from its initial state, or a build fails.
pub fn as_found(options: &[String]) -> Result<()> {
    peers::install_python()?;
    run("cargo", &["build", "--locked", "--features", "peers", "--bin", "lockstep", "--bin", "canvass"])?;
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    run(peers::PYTHON, &[&[JUDGE, "--lockstep", LOCKSTEP, "--canvass", CANVASS], &options[..]].concat())
}
