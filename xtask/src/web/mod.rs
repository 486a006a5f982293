//! The page: the libraries as WebAssembly with what shows them, as a folder and as one file, in `target/page`.

mod bind;

use crate::consent;
use crate::run::{is_there, run};
use crate::target;
use anyhow::{Result, bail, ensure};
use std::path::Path;

/// Where the page is made.
pub const FOLDER: &str = "target/page";
const TARGET: &str = "wasm32-unknown-unknown";
const WASM: &str = "target/wasm32-unknown-unknown/web/canvass_web.wasm";
/// What of the page is not Rust.
const SOURCE: &str = "web/page";
/// The page may be sent by mail: its WebAssembly, compressed, at most.
const MOST: u64 = 2_500_000;

/// Makes the page.
///
/// # Errors
/// If something is missing for that, or fails.
pub fn build() -> Result<()> {
    let missing = missing();
    ensure!(missing.is_empty(), "the page can't be made: {}", missing.join("; "));
    install()?;
    run("cargo", &["build", "--package", "canvass-web", "--target", TARGET, "--profile", "web", "--locked"])?;
    bind::bind(WASM, &format!("{FOLDER}/wasm"))?;
    run("node", &[&format!("{SOURCE}/build.mjs"), FOLDER])?;
    let size = std::fs::metadata(format!("{FOLDER}/wasm/canvass_web.wasm.gz"))?.len();
    eprintln!("WebAssembly, compressed: {size} bytes");
    ensure!(size < MOST, "expected less than {MOST} bytes");
    Ok(())
}

/// What [`build`] asks an xtask for that can make JavaScript for WebAssembly.
///
/// # Errors
/// If the words are not a module and a folder, or it can't be made.
pub fn bind(words: &[String]) -> Result<()> {
    let [wasm, folder] = words else { bail!("expected a module and a folder") };
    bind::bind(wasm, folder)
}

/// Makes the page and tries it: the same bytes as the program's for every sample, and no request in Chromium.
///
/// # Errors
/// If it can't be made, or a test fails.
pub fn test() -> Result<()> {
    build()?;
    run("cargo", &["build", "--locked", "--bin", "canvass"])?;
    run("node", &["--test", "web/page/tests/"])?;
    run("cargo", &["test", "--locked", "--features", "page", "--test", "page"])
}

/// The step of CI: where something is missing that can't be had, it is left out, and said so.
///
/// # Errors
/// As [`test`].
#[allow(dead_code)]
pub fn step() -> Result<()> {
    let missing = missing();
    if missing.is_empty() {
        return test();
    }
    eprintln!("LEFT OUT: the page was neither made nor tested, because {}", missing.join("; "));
    Ok(())
}

/// What is neither there nor to be had.
fn missing() -> Vec<String> {
    let mut missing = Vec::new();
    if let Err(error) = target::add(TARGET) {
        missing.push(format!("{error:#}"));
    }
    for program in ["node", "npm"] {
        if !is_there(program, &["--version"]) {
            missing.push(format!("{program} is missing: Debian's packages nodejs and npm bring it"));
        }
    }
    missing
}

/// The packages that the lock file names, where they are not there yet.
fn install() -> Result<()> {
    if Path::new(SOURCE).join("node_modules/.package-lock.json").exists() {
        return Ok(());
    }
    consent::ask("esbuild", &format!("npm ci --prefix {SOURCE}"))?;
    if run("npm", &["ci", "--no-audit", "--no-fund", "--prefix", SOURCE]).is_err() {
        bail!("npm could not install what {SOURCE}/package-lock.json names");
    }
    Ok(())
}
