//! The RPM packages: installed by rpm into an empty system, run and removed.

use super::{archives, clean, exercise, inside, output, sample_in};
use crate::dist::{file, rpm, system};
use crate::packages;
use anyhow::{Result, ensure};
use std::path::Path;
use std::process::Command;

/// Installs both packages, one after the other.
pub fn install() -> Result<String> {
    packages::install(&[rpm::RPM])?;
    archives::install_emulators()?;
    for system in system::LINUX {
        let root = clean("rpm")?;
        let program = root.join("usr/bin/canvass");
        output(
            rpm(&root).args(["--install", "--nodeps", "--ignorearch"]).arg(file("rpm", system.rpm)?.canonicalize()?),
        )?;
        let told = output(rpm(&root).args(["--query", "--queryformat", "%{VERSION} %{LICENSE}", "canvass"]))?;
        ensure!(told == format!("{} MIT OR Apache-2.0", crate::dist::VERSION), "rpm tells {told:?}");
        let sample = sample_in(&root)?;
        match system.emulator {
            None => exercise(&|words| inside(&root, &[&["/usr/bin/canvass"], words].concat()), sample)?,
            Some(_) => {
                let sample = super::absolute(&root.join(&sample[1..]))?;
                exercise(&|words| archives::runner(system, &program, words), &sample)?;
            }
        }
        output(rpm(&root).args(["--erase", "--nodeps", "canvass"]))?;
        ensure!(!program.exists(), "the program is still there after the package was removed");
    }
    Ok("installed by rpm in an empty system, run, removed".to_owned())
}

/// rpm with its database in this root. Debian's rpm has no database of its own, so nothing tells it what Linux provides.
fn rpm(root: &Path) -> Command {
    let mut rpm = Command::new("rpm");
    rpm.arg("--root").arg(root).args(["--define", "_dbpath /var/lib/rpm"]);
    rpm
}
