//! `cargo xtask dist`: what is given away. A static program with its manual pages and completions as an archive and as a Debian
//! package, and the checksums of both, in `target/dist`.

use crate::consent;
use crate::packages::{self, Package};
use crate::run::{is_there, run};
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

const FOLDER: &str = "target/dist";
/// No library of the machine is needed.
const TARGET: &str = "x86_64-unknown-linux-musl";
const PROGRAM: &str = "target/x86_64-unknown-linux-musl/release/canvass";
/// The C parts (zstd, lz4) need a compiler for that target.
const COMPILER: [Package; 1] = [Package { program: "musl-gcc", probe: &["--version"], package: "musl-tools" }];
/// Each shell, and what its file is called.
const COMPLETIONS: [(&str, &str); 3] = [("bash", "canvass.bash"), ("zsh", "_canvass"), ("fish", "canvass.fish")];
/// What lies beside the program in the archive.
const BESIDE: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// Builds all of it.
pub fn dist() -> Result<()> {
    packages::install(&COMPILER)?;
    add_target()?;
    install_cargo_deb()?;
    run("cargo", &["build", "--release", "--locked", "--bin", "canvass", "--target", TARGET])?;
    ensure_static()?;
    lay_out()?;
    let archive = archive()?;
    run("cargo", &["deb", "--no-build", "--no-strip", "--target", TARGET, "--output", FOLDER])?;
    let package = std::fs::read_dir(FOLDER)?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .find(|name| name.ends_with(".deb"))
        .context("cargo deb left no package")?;
    let sums =
        Command::new("sha256sum").args([&archive, &package]).current_dir(FOLDER).output().context("sha256sum")?;
    ensure!(sums.status.success(), "sha256sum ended with {}", sums.status);
    std::fs::write(Path::new(FOLDER).join("SHA256SUMS"), &sums.stdout)?;
    print!("{}", String::from_utf8_lossy(&sums.stdout));
    Ok(())
}

fn add_target() -> Result<()> {
    let installed = Command::new("rustup").args(["target", "list", "--installed"]).output().context("rustup")?;
    if String::from_utf8_lossy(&installed.stdout).lines().any(|line| line == TARGET) {
        return Ok(());
    }
    consent::ask(&format!("Rust's library for {TARGET}"), &format!("rustup target add {TARGET}"))?;
    run("rustup", &["target", "add", TARGET])
}

fn install_cargo_deb() -> Result<()> {
    if is_there("cargo", &["deb", "--version"]) {
        return Ok(());
    }
    consent::ask("cargo-deb", "cargo install --locked cargo-deb")?;
    run("cargo", &["install", "--locked", "cargo-deb"])
}

/// A program that asks for a library of the machine would not run on every one.
fn ensure_static() -> Result<()> {
    let output = Command::new("ldd").arg(PROGRAM).output().context("ldd")?;
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let is_static = said.contains("statically linked") || said.contains("not a dynamic executable");
    ensure!(is_static, "expected a static program, found {PROGRAM} with {said}");
    Ok(())
}

/// Manual pages and completions, which the program itself writes.
fn lay_out() -> Result<()> {
    if Path::new(FOLDER).exists() {
        std::fs::remove_dir_all(FOLDER)?;
    }
    std::fs::create_dir_all(format!("{FOLDER}/man"))?;
    std::fs::create_dir_all(format!("{FOLDER}/completions"))?;
    run(PROGRAM, &["man", "--out", &format!("{FOLDER}/man")])?;
    for (shell, file) in COMPLETIONS {
        let script = Command::new(PROGRAM).args(["completions", shell]).output().context(PROGRAM)?;
        ensure!(script.status.success(), "canvass completions {shell} ended with {}", script.status);
        std::fs::write(format!("{FOLDER}/completions/{file}"), script.stdout)?;
    }
    Ok(())
}

/// The name of the archive.
fn archive() -> Result<String> {
    let name = format!("canvass-{}-{TARGET}", env!("CARGO_PKG_VERSION"));
    let root = format!("{FOLDER}/{name}");
    std::fs::create_dir_all(&root)?;
    for file in BESIDE.iter().chain([&PROGRAM]) {
        let to = Path::new(&root).join(Path::new(file).file_name().context("a file")?);
        std::fs::copy(file, to).with_context(|| (*file).to_owned())?;
    }
    run("cp", &["-r", &format!("{FOLDER}/man"), &format!("{FOLDER}/completions"), &root])?;
    let file = format!("{name}.tar.gz");
    // The same files make the same bytes.
    let order = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0"];
    run("tar", &[&order[..], &["-C", FOLDER, "-czf", &format!("{FOLDER}/{file}"), &name]].concat())?;
    std::fs::remove_dir_all(root)?;
    Ok(file)
}
