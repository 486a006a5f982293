//! The npm packages: installed without a registry, run and removed.

use super::{SAMPLE, absolute, bare, clean, exercise, output};
use crate::dist::{files, npm};
use anyhow::{Result, ensure};
use std::process::Command;

/// Installs the package that starts the program, and that of this system.
pub fn install() -> Result<String> {
    let folder = clean("npm")?;
    let of_others = |path: &str| ["arm64", "win32"].iter().any(|other| path.contains(other));
    let packages: Vec<String> = files("npm")?.iter().map(|path| absolute(path)).collect::<Result<_>>()?;
    let npm = |words: &[&str]| {
        let mut npm = Command::new(npm::NPM.program);
        npm.args(words).args(["--prefix"]).arg(&folder).args(["--no-audit", "--no-fund", "--offline"]);
        npm
    };
    let ours: Vec<&str> = packages.iter().map(String::as_str).filter(|path| !of_others(path)).collect();
    ensure!(ours.len() == 2, "expected two packages for this system, found {ours:?}");
    output(&mut npm(&[&["install"], &ours[..]].concat()))?;
    let program = folder.join("node_modules/.bin/canvass");
    let started = |words: &[&str]| {
        let mut command = bare(&program);
        command.args(words);
        command
    };
    exercise(&started, &absolute(SAMPLE.as_ref())?)?;
    let status = started(&["decode", "/no/such/file"]).output()?.status;
    ensure!(status.code() == Some(2), "expected the exit status of the program, 2, found {status}");
    output(&mut npm(&["uninstall", "canvass", "@canvass/linux-x64"]))?;
    ensure!(!program.exists(), "{} is still there after the removal", program.display());
    Ok("installed by npm off line, run, removed".to_owned())
}
