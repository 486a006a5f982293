//! The RPM packages, for Fedora, Red Hat, SUSE and what is built on them.

use super::{FOLDER, VERSION, filled, scratch, system};
use crate::packages::{self, Package};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The program that makes the packages.
pub const RPM: Package = Package { program: "rpmbuild", probe: &["--version"], package: "rpm" };

/// Fetches what makes the packages.
pub fn prepare() -> Result<()> {
    ensure!(system::AARCH64.program().exists(), "it holds the programs for Linux: cargo xtask dist linux");
    packages::install(&[RPM])
}

/// A package for each processor.
pub fn make() -> Result<Vec<String>> {
    system::LINUX.iter().map(|system| package(system)).collect()
}

fn package(system: &system::System) -> Result<String> {
    let here = std::env::current_dir()?;
    let root = here.join(system::root(system)?);
    let work = here.join(scratch("rpm")?);
    let spec = work.join("canvass.spec");
    fs::write(&spec, filled("packaging/canvass.spec", &[("ROOT", &root.to_string_lossy())])?)?;
    let mut rpmbuild = Command::new(RPM.program);
    rpmbuild.args(["-bb", "--quiet", "--target", system.rpm]);
    // The same files give the same package, on whatever machine.
    for define in [
        format!("_topdir {}", work.display()),
        "_buildhost canvass".into(),
        "clamp_mtime_to_source_date_epoch 1".into(),
    ] {
        rpmbuild.args(["--define", &define]);
    }
    let status = rpmbuild.arg(&spec).env("SOURCE_DATE_EPOCH", "0").status().context("rpmbuild")?;
    ensure!(status.success(), "rpmbuild ended with {status}");
    let file = format!("canvass-{VERSION}-1.{}.rpm", system.rpm);
    fs::copy(work.join("RPMS").join(system.rpm).join(&file), Path::new(FOLDER).join(&file)).context("the package")?;
    Ok(file)
}
