//! Debian packages that tests and benchmarks need.

use crate::consent;
use crate::run::{is_there, run};
use anyhow::{Result, bail};

/// A program and the Debian package that contains it.
pub struct Package {
    /// The name of the program.
    pub program: &'static str,
    /// Arguments with which the program only shows that it works.
    pub probe: &'static [&'static str],
    /// The name of the package.
    pub package: &'static str,
}

/// Installs missing packages with apt-get (and sudo if needed).
pub fn install(packages: &[Package]) -> Result<()> {
    let missing: Vec<_> = packages.iter().filter(|p| !is_there(p.program, p.probe)).map(|p| p.package).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let names = missing.join(" ");
    consent::ask(&names, &format!("apt-get install {names}"))?;
    if !is_there("apt-get", &["--version"]) {
        bail!("{} must be installed: there is no apt-get on this machine to do it", missing.join(", "));
    }
    let sudo = !is_root() && is_there("sudo", &["-n", "true"]);
    let apt_get = |args: &[&str]| {
        let mut all: Vec<&str> = if sudo { vec!["sudo", "apt-get"] } else { vec!["apt-get"] };
        all.extend_from_slice(args);
        run(all[0], &all[1..])
    };
    apt_get(&["update", "-qq"])?;
    let mut args = vec!["install", "-y", "-qq", "--no-install-recommends"];
    args.extend(missing);
    apt_get(&args)
}

fn is_root() -> bool {
    std::process::Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}
