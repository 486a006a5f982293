//! The systems that a release serves, and the program for each.

use super::{FOLDER, tools};
use crate::packages::{self, Package};
use crate::run::run;
use crate::{target, windows};
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// A system that a release serves. Each kind of package has its own word for a processor.
pub struct System {
    /// Rust's target.
    pub target: &'static str,
    /// Debian's name of the processor.
    pub debian: &'static str,
    /// The processor in the names of RPM packages.
    pub rpm: &'static str,
    /// The processor in container images.
    pub container: &'static str,
    /// Node's names of the system and of its processor.
    pub node: (&'static str, &'static str),
    /// The program that runs programs of this processor on another one; nothing for this machine's own.
    pub emulator: Option<Package>,
}

/// The processor of most computers. The C parts (zstd, lz4) are compiled by musl's own compiler.
pub const X86_64: System = System {
    target: "x86_64-unknown-linux-musl",
    debian: "amd64",
    rpm: "x86_64",
    container: "amd64",
    node: ("linux", "x64"),
    emulator: None,
};
/// The processor of small computers beside machines, such as the Raspberry Pi. Zig compiles the C parts and links.
pub const AARCH64: System = System {
    target: "aarch64-unknown-linux-musl",
    debian: "arm64",
    rpm: "aarch64",
    container: "arm64",
    node: ("linux", "arm64"),
    emulator: Some(Package { program: "qemu-aarch64-static", probe: &["--version"], package: "qemu-user-static" }),
};
/// The systems with packages of Linux.
pub const LINUX: [&System; 2] = [&X86_64, &AARCH64];

const MUSL_COMPILER: Package = Package { program: "musl-gcc", probe: &["--version"], package: "musl-tools" };

impl System {
    /// The program for this system.
    pub fn program(&self) -> PathBuf {
        crate::run::target_folder().join(self.target).join("release/canvass")
    }

    /// Fetches what building takes.
    ///
    /// # Errors
    /// If a tool is missing and may not be installed.
    pub fn prepare(&self) -> Result<()> {
        match &self.emulator {
            None => packages::install(&[MUSL_COMPILER])?,
            Some(_) => tools::VENV.install()?,
        }
        target::add(self.target)
    }

    /// Builds the program, which runs on every machine with this processor.
    ///
    /// # Errors
    /// If it can't be built, or asks for libraries of the machine.
    pub fn build(&self) -> Result<()> {
        let mut cargo = Command::new("cargo");
        cargo.arg(if self.emulator.is_some() { "zigbuild" } else { "build" });
        cargo.args(["--release", "--locked", "--bin", "canvass", "--target", self.target]);
        tools::with_zig(&mut cargo)?;
        release(&mut cargo)?;
        self.ensure_static()
    }

    /// A dynamic program would not run on every machine.
    fn ensure_static(&self) -> Result<()> {
        let program = self.program();
        let output = Command::new("readelf").arg("--program-headers").arg(&program).output().context("readelf")?;
        ensure!(output.status.success(), "readelf ended with {}", output.status);
        let headers = String::from_utf8_lossy(&output.stdout);
        ensure!(
            !headers.contains("INTERP"),
            "expected a statically linked program; {} asks for a program that loads libraries",
            program.display()
        );
        Ok(())
    }
}

/// Builds the program for Windows.
///
/// # Errors
/// If it can't be built.
pub fn build_for_windows() -> Result<()> {
    let mut cargo = windows::cargo()?;
    cargo.command.args(["build", "--release", "--locked", "--bin", "canvass", "--target", windows::TARGET]);
    release(&mut cargo.command)
}

/// The program for Windows.
pub fn program_for_windows() -> PathBuf {
    crate::run::target_folder().join(windows::TARGET).join("release/canvass.exe")
}

/// Runs cargo for a release: the program tells the commit from which it was made.
fn release(cargo: &mut Command) -> Result<()> {
    let words: Vec<_> = cargo.get_args().map(std::ffi::OsStr::to_string_lossy).collect();
    eprintln!("$ cargo {}", words.join(" "));
    let status = cargo.env("CANVASS_COMMIT", commit()).status().context("cargo")?;
    ensure!(status.success(), "cargo ended with {status}");
    Ok(())
}

/// The commit of the work tree, which `canvass --version --verbose` tells.
pub fn commit() -> String {
    let told = |args: &[&str]| Command::new("git").args(args).output().ok().filter(|output| output.status.success());
    let text = |output: std::process::Output| String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let head = told(&["rev-parse", "--short=12", "HEAD"]).map(text).unwrap_or_default();
    let is_changed = told(&["status", "--porcelain"]).map(text).is_none_or(|changes| !changes.is_empty());
    if head.is_empty() || !is_changed { head } else { format!("{head}, changed") }
}

/// Each shell, and where Linux looks for its completions.
pub const COMPLETIONS: [(&str, &str); 3] = [
    ("bash", "usr/share/bash-completion/completions/canvass"),
    ("zsh", "usr/share/zsh/vendor-completions/_canvass"),
    ("fish", "usr/share/fish/vendor_completions.d/canvass.fish"),
];
/// Files that every archive and package has besides the program.
pub const BESIDE: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// The files of a package for Linux, at their places below a root: the program, its manual pages and completions, and
/// what stands beside it. The program of this machine writes the pages.
///
/// # Errors
/// If a file can't be written.
pub fn root(system: &System) -> Result<PathBuf> {
    let root = Path::new(FOLDER).join("root").join(system.target);
    let man = root.join("usr/share/man/man1");
    let documents = root.join("usr/share/doc/canvass");
    for folder in [&root.join("usr/bin"), &man, &documents] {
        std::fs::create_dir_all(folder)?;
    }
    std::fs::copy(system.program(), root.join("usr/bin/canvass")).context("the program")?;
    for file in BESIDE {
        std::fs::copy(file, documents.join(file)).context(file)?;
    }
    let writer = X86_64.program();
    run(&writer.to_string_lossy(), &["man", "--out", &man.to_string_lossy()])?;
    for (shell, file) in COMPLETIONS {
        completions(shell, &root.join(file))?;
    }
    Ok(root)
}

/// Writes the completions of a shell.
///
/// # Errors
/// If the program of this machine does not write them.
pub fn completions(shell: &str, file: &Path) -> Result<()> {
    let script = Command::new(X86_64.program()).args(["completions", shell]).output().context("canvass completions")?;
    ensure!(script.status.success(), "canvass completions {shell} ended with {}", script.status);
    std::fs::create_dir_all(file.parent().context("a folder")?)?;
    std::fs::write(file, script.stdout).with_context(|| file.display().to_string())
}
