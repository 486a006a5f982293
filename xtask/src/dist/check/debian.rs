//! The Debian packages: installed by apt in a new Debian, from the repository as a web server serves it.

use super::{archives, clean, exercise, inside, output, sample_in};
use crate::dist::{debian, file, system};
use crate::packages::{self, Package};
use anyhow::{Context, Result, ensure};
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

const DEBOOTSTRAP: Package = Package { program: "debootstrap", probe: &["--version"], package: "debootstrap" };
/// The release of Debian that is installed.
const RELEASE: &str = "bookworm";
const MIRROR: &str = "http://deb.debian.org/debian";
/// A new Debian, which is copied for each check.
const NEW: &str = "target/dist-debian";

/// Installs the package of this processor by apt, runs and removes it; unpacks and runs that of the other one.
pub fn install() -> Result<String> {
    packages::install(&[DEBOOTSTRAP])?;
    let root = root()?;
    let server = Server::start(debian::REPOSITORY)?;
    let key = "/usr/share/keyrings/canvass.gpg";
    fs::copy(Path::new(debian::REPOSITORY).join(debian::KEY), root.join(&key[1..]))?;
    let source = format!("deb [signed-by={key}] {} stable main\n", server.address);
    fs::write(root.join("etc/apt/sources.list"), source)?;
    output(&mut inside(&root, &["apt-get", "-qq", "update"]))?;
    output(inside(&root, &["apt-get", "-qq", "install", "canvass"]).env("DEBIAN_FRONTEND", "noninteractive"))?;
    let sample = sample_in(&root)?;
    exercise(&|words| inside(&root, &[&["canvass"], words].concat()), sample)?;
    for installed in INSTALLED {
        ensure!(root.join(installed).exists(), "{installed} is missing");
    }
    output(&mut inside(&root, &["apt-get", "-qq", "purge", "canvass"]))?;
    for installed in INSTALLED {
        ensure!(!root.join(installed).exists(), "{installed} is still there after the package was removed");
    }
    without_the_key(&root)?;
    other_processor()?;
    Ok("installed by apt in a new Debian, run, removed; refused without its key".to_owned())
}

/// Files of the package.
const INSTALLED: [&str; 2] = ["usr/bin/canvass", "usr/share/bash-completion/completions/canvass"];

/// A signature by a key that the user does not trust is refused.
fn without_the_key(root: &Path) -> Result<()> {
    let sources = root.join("etc/apt/sources.list");
    let trusted = fs::read_to_string(&sources)?;
    fs::write(&sources, trusted.replace("canvass.gpg", "debian-archive-keyring.gpg"))?;
    let refused = inside(root, &["apt-get", "-qq", "-o", "APT::Update::Error-Mode=any", "update"]).output()?;
    ensure!(!refused.status.success(), "apt took a repository that is not signed by a key that it trusts");
    Ok(())
}

fn other_processor() -> Result<()> {
    let system = &system::AARCH64;
    archives::install_emulators()?;
    let folder = clean("debian-other")?;
    output(Command::new("dpkg-deb").arg("-x").arg(file("deb", system.debian)?).arg(&folder))?;
    let sample = super::absolute(super::SAMPLE.as_ref())?;
    exercise(&|words| archives::runner(system, &folder.join("usr/bin/canvass"), words), &sample)
}

/// A copy of a new Debian.
fn root() -> Result<PathBuf> {
    let new = Path::new(NEW);
    if !new.join("usr/bin/apt-get").exists() {
        let mut debootstrap = Command::new(DEBOOTSTRAP.program);
        output(debootstrap.args(["--variant=minbase", RELEASE, NEW, MIRROR]))?;
    }
    let root = clean("debian")?;
    output(Command::new("cp").arg("-a").arg(new.join(".")).arg(&root))?;
    Ok(root)
}

/// A web server of a folder, as anyone has it.
struct Server {
    process: Child,
    address: String,
}

impl Server {
    fn start(folder: &str) -> Result<Self> {
        let mut python = Command::new("python3");
        python.args(["-u", "-m", "http.server", "--bind", "127.0.0.1", "--directory", folder, "0"]);
        let mut process = python.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().context("python3")?;
        let mut line = String::new();
        BufReader::new(process.stdout.take().context("python3")?).read_line(&mut line)?;
        // "Serving HTTP on 127.0.0.1 port 41235 (http://127.0.0.1:41235/) ..."
        let address = line.split(['(', ')']).nth(1).map(str::to_owned);
        let address =
            address.with_context(|| format!("expected the address of python's web server, found {line:?}"))?;
        Ok(Self { process, address })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // A server that has ended by itself needs no end.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
