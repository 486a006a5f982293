//! The Debian packages, and an apt repository that holds them: a folder for any web server.

use super::{FOLDER, filled, scratch, system, tools};
use crate::packages::{self, Package};
use crate::run::run;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The folder of the repository.
pub const REPOSITORY: &str = "target/dist/apt";
/// The public key of the repository, in the folder: the form that apt reads.
pub const KEY: &str = "canvass.gpg";
/// Names the key that signs a published repository, in the keyring of the user. Without it a new key is made, which
/// serves to test the repository only.
const SIGNING_KEY: &str = "CANVASS_SIGNING_KEY";
const TOOLS: [Package; 2] = [
    Package { program: "reprepro", probe: &["--version"], package: "reprepro" },
    Package { program: "gpg", probe: &["--version"], package: "gnupg" },
];

/// Fetches what makes packages and repository.
pub fn prepare() -> Result<()> {
    ensure!(system::AARCH64.program().exists(), "it holds the programs for Linux: cargo xtask dist linux");
    packages::install(&TOOLS)?;
    tools::install_subcommand("cargo-deb")
}

/// The packages, and beside them the repository.
pub fn make() -> Result<Vec<String>> {
    let made: Vec<String> = system::LINUX.iter().map(|system| package(system)).collect::<Result<_>>()?;
    repository(&made)?;
    Ok(made)
}

fn package(system: &system::System) -> Result<String> {
    let root = system::root(system)?;
    // The list of files in Cargo.toml names one place for both processors.
    let place = Path::new(FOLDER).join("root/debian");
    if place.exists() {
        fs::remove_dir_all(&place)?;
    }
    run("cp", &["-r", &root.to_string_lossy(), &place.to_string_lossy()])?;
    let file = format!("canvass_{}-1_{}.deb", super::VERSION, system.debian);
    let output = format!("{FOLDER}/{file}");
    run("cargo", &["deb", "--no-build", "--no-strip", "--target", system.target, "--output", &output])?;
    Ok(file)
}

/// Puts the packages into a new repository, and signs it.
fn repository(packages: &[String]) -> Result<()> {
    let repository = std::env::current_dir()?.join(REPOSITORY);
    if repository.exists() {
        fs::remove_dir_all(&repository)?;
    }
    let work = std::env::current_dir()?.join(scratch("apt")?);
    let keyring = Keyring::open(&work)?;
    let processors: Vec<&str> = system::LINUX.iter().map(|system| system.debian).collect();
    fs::create_dir_all(work.join("conf"))?;
    let words = [("PROCESSORS", processors.join(" ")), ("KEY", keyring.key.clone())];
    let words: Vec<(&str, &str)> = words.iter().map(|(word, value)| (*word, value.as_str())).collect();
    fs::write(work.join("conf/distributions"), filled("packaging/distributions", &words)?)?;
    for package in packages {
        let mut reprepro = keyring.with(Command::new("reprepro"));
        reprepro.arg("--silent").arg("--basedir").arg(&work).arg("--outdir").arg(&repository);
        reprepro.args(["includedeb", "stable"]).arg(Path::new(FOLDER).join(package));
        let status = reprepro.status().context("reprepro")?;
        ensure!(status.success(), "reprepro ended with {status}");
    }
    let exported = keyring.with(Command::new("gpg")).args(["--batch", "--export", &keyring.key]).output()?;
    ensure!(exported.status.success() && !exported.stdout.is_empty(), "gpg did not export {}", keyring.key);
    fs::write(repository.join(KEY), exported.stdout)?;
    eprintln!("{REPOSITORY}: an apt repository, signed by {}", keyring.key);
    Ok(())
}

/// The key that signs, and where gpg finds it.
struct Keyring {
    key: String,
    home: Option<PathBuf>,
}

impl Keyring {
    /// The user's key, if it is named; otherwise a new one.
    fn open(work: &Path) -> Result<Self> {
        if let Ok(key) = std::env::var(SIGNING_KEY) {
            return Ok(Self { key, home: None });
        }
        // gpg's agent takes no longer paths for its socket than 107 bytes, which those of a project may exceed.
        let home = tempfile::Builder::new().prefix("canvass-gpg-").tempdir()?.keep();
        let test = Self { key: "test@canvass.invalid".to_owned(), home: Some(home) };
        let mut gpg = test.with(Command::new("gpg"));
        gpg.args(["--batch", "--quiet", "--passphrase", "", "--quick-generate-key"]);
        gpg.args([&format!("canvass, a key for tests <{}>", test.key), "ed25519", "sign", "never"]);
        let status = gpg.current_dir(work).status().context("gpg")?;
        ensure!(status.success(), "gpg ended with {status}");
        eprintln!("{SIGNING_KEY} names no key: the repository is signed by a new one, for tests only");
        Ok(test)
    }

    fn with(&self, mut command: Command) -> Command {
        if let Some(home) = &self.home {
            command.env("GNUPGHOME", home);
        }
        command
    }
}

impl Drop for Keyring {
    /// A key for tests is not kept.
    fn drop(&mut self) {
        if let Some(home) = &self.home {
            // What remains of a failed removal is a key that nobody trusts.
            let _ = self.with(Command::new("gpgconf")).args(["--kill", "all"]).status();
            let _ = fs::remove_dir_all(home);
        }
    }
}
