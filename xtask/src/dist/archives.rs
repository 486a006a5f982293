//! The archives, which need no installation: unpack one and start the program in it.

use super::{FOLDER, name, scratch, system};
use crate::packages::{self, Package};
use crate::run::run;
use crate::{target, web, windows};
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::Command;

/// The archives for Windows and of the page are zip files, which Windows opens itself.
const ZIP: Package = Package { program: "zip", probe: &["--version"], package: "zip" };

/// Fetches the compilers of both processors.
pub fn prepare_linux() -> Result<()> {
    system::LINUX.iter().try_for_each(|system| system.prepare())
}

/// The programs for Linux, each with its manual pages and completions.
pub fn linux() -> Result<Vec<String>> {
    system::LINUX.iter().try_for_each(|system| system.build())?;
    system::LINUX.iter().map(|system| tar(system)).collect()
}

fn tar(system: &system::System) -> Result<String> {
    let root = system::root(system)?;
    let name = name(system.target);
    let folder = scratch("archive")?.join(&name);
    std::fs::create_dir_all(folder.join("completions"))?;
    std::fs::copy(root.join("usr/bin/canvass"), folder.join("canvass"))?;
    for file in system::BESIDE {
        std::fs::copy(file, folder.join(file)).context(file)?;
    }
    for (shell, file) in system::COMPLETIONS {
        let name = if shell == "bash" { "canvass.bash" } else { file.rsplit('/').next().unwrap_or(file) };
        std::fs::copy(root.join(file), folder.join("completions").join(name)).context(file)?;
    }
    run("cp", &["-r", &root.join("usr/share/man/man1").to_string_lossy(), &folder.join("man").to_string_lossy()])?;
    let file = format!("{name}.tar.gz");
    // Equal files give equal bytes.
    let order = ["--sort=name", "--owner=0", "--group=0", "--numeric-owner", "--mtime=@0"];
    let parent = folder.parent().context("a folder")?.to_string_lossy().into_owned();
    run("tar", &[&order[..], &["-C", &parent, "-czf", &format!("{FOLDER}/{file}"), &name]].concat())?;
    Ok(file)
}

/// Fetches the compiler for Windows.
pub fn prepare_windows() -> Result<()> {
    packages::install(&[windows::COMPILER, ZIP])?;
    target::add(windows::TARGET)
}

/// The program for Windows.
pub fn windows() -> Result<Vec<String>> {
    system::build_for_windows()?;
    let name = name(windows::TARGET);
    let scratch = scratch("windows")?;
    let folder = scratch.join(&name);
    std::fs::create_dir_all(&folder)?;
    lay_out_windows(&folder)?;
    Ok(vec![zip(&scratch, &name)?])
}

/// Puts the files for Windows into a folder: the program and what stands beside it.
///
/// # Errors
/// If a file is missing.
pub fn lay_out_windows(folder: &Path) -> Result<()> {
    std::fs::copy(system::program_for_windows(), folder.join("canvass.exe")).context("canvass.exe")?;
    for file in system::BESIDE {
        std::fs::copy(file, folder.join(file)).context(file)?;
    }
    // The program for Linux writes the completions, as the program for Windows does not run here.
    system::completions("powershell", &folder.join("canvass.ps1"))
}

/// Fetches what makes the page.
pub fn prepare_page() -> Result<()> {
    packages::install(&[ZIP])?;
    web::prepare()
}

/// The page: a folder for a server, and a single file.
pub fn page() -> Result<Vec<String>> {
    web::build()?;
    let name = name("page");
    let scratch = scratch("page")?;
    let folder = scratch.join(&name);
    run("cp", &["-r", &format!("{}/folder", web::FOLDER), &folder.to_string_lossy()])?;
    let file = format!("{name}.html");
    std::fs::copy(format!("{}/canvass.html", web::FOLDER), format!("{FOLDER}/{file}"))?;
    Ok(vec![zip(&scratch, &name)?, file])
}

/// Packs a folder; returns the name of the archive. The same files give the same bytes: all dates are the first day
/// that such archives know, and owners are omitted.
fn zip(parent: &Path, folder: &str) -> Result<String> {
    let file = format!("{folder}.zip");
    let archive = std::env::current_dir()?.join(FOLDER).join(&file);
    if archive.exists() {
        std::fs::remove_file(&archive)?;
    }
    let script =
        "find \"$1\" -exec touch -d 1980-01-01T00:00:00Z {} + && find \"$1\" -type f | sort | zip -X -q \"$2\" -@";
    eprintln!("$ zip {file}");
    let mut shell = Command::new("sh");
    shell.args(["-ec", script, "sh", folder]).arg(archive).env("TZ", "UTC").current_dir(parent);
    let status = shell.status()?;
    ensure!(status.success(), "zip ended with {status}");
    Ok(file)
}
