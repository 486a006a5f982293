//! `cargo xtask dist`: the release files, in `target/dist`. A static program for Linux with its manual pages and
//! completions, as an archive and as a Debian package; the program for Windows; the page; and all checksums.

use crate::consent;
use crate::packages::{self, Package};
use crate::run::{is_there, run};
use crate::{target, web, windows};
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

const FOLDER: &str = "target/dist";
/// The target of the static program.
const TARGET: &str = "x86_64-unknown-linux-musl";
const PROGRAM: &str = "target/x86_64-unknown-linux-musl/release/canvass";
const ON_WINDOWS: &str = "target/x86_64-pc-windows-gnu/release/canvass.exe";
/// The C parts (zstd, lz4) need a compiler for each target.
const COMPILER: Package = Package { program: "musl-gcc", probe: &["--version"], package: "musl-tools" };
/// The archives for Windows and of the page are zip files, which Windows opens itself.
const ZIP: Package = Package { program: "zip", probe: &["--version"], package: "zip" };
/// Each shell, and the name of its file.
const COMPLETIONS: [(&str, &str); 3] = [("bash", "canvass.bash"), ("zsh", "_canvass"), ("fish", "canvass.fish")];
const POWERSHELL: (&str, &str) = ("powershell", "canvass.ps1");
/// Further files in the archives.
const BESIDE: [&str; 4] = ["README.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"];

/// A part of the release.
struct Part {
    name: &'static str,
    /// Fetches its tools; fails if they are not available here.
    prepare: fn() -> Result<()>,
    /// Makes the part; returns the names of its files.
    make: fn() -> Result<Vec<String>>,
}

const PARTS: [Part; 4] = [
    Part { name: "the program for Linux", prepare: prepare_linux, make: linux },
    Part { name: "the Debian package", prepare: prepare_package, make: package },
    Part { name: "the program for Windows", prepare: prepare_windows, make: windows },
    Part { name: "the page", prepare: prepare_page, make: page },
];

/// Makes all parts. A part with a missing tool is left out with a message; the others are made.
///
/// # Errors
/// If a part can't be made or was left out.
pub fn dist() -> Result<()> {
    if Path::new(FOLDER).exists() {
        std::fs::remove_dir_all(FOLDER)?;
    }
    std::fs::create_dir_all(FOLDER)?;
    let (mut products, mut left_out) = (Vec::new(), Vec::new());
    for Part { name, prepare, make } in PARTS {
        match prepare() {
            Ok(()) => products.extend(make().with_context(|| name.to_owned())?),
            Err(missing) => left_out.push(format!("{name} was left out: {missing:#}")),
        }
    }
    if !products.is_empty() {
        let sums = Command::new("sha256sum").args(&products).current_dir(FOLDER).output().context("sha256sum")?;
        ensure!(sums.status.success(), "sha256sum ended with {}", sums.status);
        std::fs::write(Path::new(FOLDER).join("SHA256SUMS"), &sums.stdout)?;
        print!("{}", String::from_utf8_lossy(&sums.stdout));
    }
    ensure!(left_out.is_empty(), "parts are missing: {}", left_out.join("; "));
    Ok(())
}

fn prepare_linux() -> Result<()> {
    packages::install(&[COMPILER])?;
    target::add(TARGET)
}

/// The commit of the work tree, which `canvass --version --verbose` tells.
fn commit() -> String {
    let told = |args: &[&str]| Command::new("git").args(args).output().ok().filter(|output| output.status.success());
    let text = |output: std::process::Output| String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let head = told(&["rev-parse", "--short=12", "HEAD"]).map(text).unwrap_or_default();
    let is_changed = told(&["status", "--porcelain"]).map(text).is_none_or(|changes| !changes.is_empty());
    if head.is_empty() || !is_changed { head } else { format!("{head}, changed") }
}

/// The program with its manual pages and completions, as an archive.
fn linux() -> Result<Vec<String>> {
    let commit = format!("CANVASS_COMMIT={}", commit());
    run("env", &[&commit, "cargo", "build", "--release", "--locked", "--bin", "canvass", "--target", TARGET])?;
    ensure_static()?;
    lay_out()?;
    Ok(vec![archive()?])
}

fn prepare_package() -> Result<()> {
    ensure!(Path::new(FOLDER).join("man").exists(), "it holds the program for Linux, which was not made");
    install_cargo_deb()
}

fn prepare_windows() -> Result<()> {
    packages::install(&[windows::COMPILER, ZIP])?;
    target::add(windows::TARGET)
}

fn windows() -> Result<Vec<String>> {
    windows::release()?;
    Ok(vec![archive_for_windows()?])
}

fn prepare_page() -> Result<()> {
    packages::install(&[ZIP])?;
    web::prepare()
}

fn install_cargo_deb() -> Result<()> {
    if is_there("cargo", &["deb", "--version"]) {
        return Ok(());
    }
    consent::ask("cargo-deb", "cargo install --locked cargo-deb")?;
    run("cargo", &["install", "--locked", "cargo-deb"])
}

/// A dynamic program would not run on every machine.
fn ensure_static() -> Result<()> {
    let output = Command::new("ldd").arg(PROGRAM).output().context("ldd")?;
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8_lossy(&said);
    let is_static = said.contains("statically linked") || said.contains("not a dynamic executable");
    ensure!(is_static, "expected a statically linked program; ldd says of {PROGRAM}: {said}");
    Ok(())
}

/// Writes the manual pages and completions with the program itself.
fn lay_out() -> Result<()> {
    std::fs::create_dir_all(format!("{FOLDER}/man"))?;
    std::fs::create_dir_all(format!("{FOLDER}/completions"))?;
    run(PROGRAM, &["man", "--out", &format!("{FOLDER}/man")])?;
    for (shell, file) in COMPLETIONS {
        completions(shell, &format!("{FOLDER}/completions/{file}"))?;
    }
    Ok(())
}

fn completions(shell: &str, file: &str) -> Result<()> {
    let script = Command::new(PROGRAM).args(["completions", shell]).output().context(PROGRAM)?;
    ensure!(script.status.success(), "canvass completions {shell} ended with {}", script.status);
    std::fs::write(file, script.stdout).with_context(|| file.to_owned())
}

/// The name of the products for a target, without extension.
fn name(target: &str) -> String {
    format!("canvass-{}-{target}", env!("CARGO_PKG_VERSION"))
}

/// A folder with the program and the further files.
fn folder(target: &str, program: &str) -> Result<String> {
    let root = format!("{FOLDER}/{}", name(target));
    std::fs::create_dir_all(&root)?;
    for file in BESIDE.iter().chain([&program]) {
        let to = Path::new(&root).join(Path::new(file).file_name().context("a file")?);
        std::fs::copy(file, to).with_context(|| (*file).to_owned())?;
    }
    Ok(root)
}

/// The name of the archive for Linux.
fn archive() -> Result<String> {
    let root = folder(TARGET, PROGRAM)?;
    run("cp", &["-r", &format!("{FOLDER}/man"), &format!("{FOLDER}/completions"), &root])?;
    let file = format!("{}.tar.gz", name(TARGET));
    // Equal files give equal bytes.
    let order = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0"];
    run("tar", &[&order[..], &["-C", FOLDER, "-czf", &format!("{FOLDER}/{file}"), &name(TARGET)]].concat())?;
    std::fs::remove_dir_all(root)?;
    Ok(file)
}

/// The Debian package.
fn package() -> Result<Vec<String>> {
    run("cargo", &["deb", "--no-build", "--no-strip", "--target", TARGET, "--output", FOLDER])?;
    let names = std::fs::read_dir(FOLDER)?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let packages: Vec<String> = names.filter(|name| name.ends_with(".deb")).collect();
    ensure!(!packages.is_empty(), "cargo deb left no package");
    Ok(packages)
}

/// The name of the archive for Windows.
fn archive_for_windows() -> Result<String> {
    let root = folder(windows::TARGET, ON_WINDOWS)?;
    // The program for Linux writes the completions, as the program for Windows does not run here.
    if Path::new(PROGRAM).exists() {
        completions(POWERSHELL.0, &format!("{root}/{}", POWERSHELL.1))?;
    }
    let file = zip(&name(windows::TARGET))?;
    std::fs::remove_dir_all(root)?;
    Ok(file)
}

/// The page: a folder for a server, and a single file.
fn page() -> Result<Vec<String>> {
    web::build()?;
    let (folder, file) = (name("page"), format!("{}.html", name("page")));
    run("cp", &["-r", &format!("{}/folder", web::FOLDER), &format!("{FOLDER}/{folder}")])?;
    let zipped = zip(&folder)?;
    std::fs::remove_dir_all(format!("{FOLDER}/{folder}"))?;
    std::fs::copy(format!("{}/canvass.html", web::FOLDER), format!("{FOLDER}/{file}"))?;
    Ok(vec![zipped, file])
}

/// Packs a folder; returns the name of the archive. The same files give the same bytes: all dates are the first day
/// that such archives know, and owners are omitted.
fn zip(folder: &str) -> Result<String> {
    let file = format!("{folder}.zip");
    let script =
        "find \"$1\" -exec touch -d 1980-01-01T00:00:00Z {} + && find \"$1\" -type f | sort | zip -X -q \"$2\" -@";
    eprintln!("$ zip {file}");
    let mut shell = Command::new("sh");
    let status = shell.args(["-ec", script, "sh", folder, &file]).env("TZ", "UTC").current_dir(FOLDER).status()?;
    ensure!(status.success(), "zip ended with {status}");
    Ok(file)
}
