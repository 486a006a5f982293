//! `cargo xtask incidents [--seed N[,N...]] [--count N]`: the diagnosis, measured by a matrix of incidents.
//! `--write CELL@SEED FILE` writes the frames of one of them as a log of candump.

use crate::seed::today;
use anyhow::{Context, Result, bail, ensure};
use std::path::Path;
use std::process::Command;

/// Default number of cells, and of healthy networks, for each seed.
const COUNT: usize = 1_000;

/// Prints the findings by operator and by service, and what the diagnosis misses.
///
/// # Errors
/// If a healthy network is accused, or too few incidents are named.
pub fn incidents(args: &[String]) -> Result<()> {
    let (mut seeds, mut count) = (today()?.to_string(), COUNT);
    let mut args = args.iter();
    while let Some(name) = args.next() {
        let mut value = || args.next().with_context(|| format!("{name} needs a value"));
        match &**name {
            "--seed" => seeds = value()?.clone(),
            "--count" => count = value()?.parse().context("--count")?,
            "--write" => return write(value()?, value()?),
            other => bail!("expected --seed, --count or --write, found {other}"),
        }
    }
    run(&[("CANVASS_MATRIX_SEEDS", &seeds), ("CANVASS_MATRIX_COUNT", &count.to_string())])
        .context("too few incidents are named, or a healthy network has a finding")
}

fn write(cell: &str, file: &str) -> Result<()> {
    let file = std::path::absolute(Path::new(file))?;
    let file = file.to_str().context("the path of FILE is no text")?;
    run(&[("CANVASS_MATRIX_WRITE", cell), ("CANVASS_MATRIX_FILE", file)])
}

/// Runs the matrix with these variables.
fn run(variables: &[(&str, &str)]) -> Result<()> {
    let test = "incidents_are_named_and_healthy_networks_are_not_accused";
    let words = ["test", "--release", "--locked", "--package", "canvass-analyzer", "--test", "matrix", test];
    let shown: Vec<String> = variables.iter().map(|(name, value)| format!("{name}={value}")).collect();
    eprintln!("$ {} cargo {} -- --nocapture", shown.join(" "), words.join(" "));
    let mut command = Command::new("cargo");
    let status = command.args(words).args(["--", "--nocapture"]).envs(variables.iter().copied()).status()?;
    ensure!(status.success(), "the matrix failed");
    Ok(())
}
