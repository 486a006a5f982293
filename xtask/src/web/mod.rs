//! The page: the libraries as WebAssembly with their user interface, as a folder and as one file, in `target/page`.

#[cfg(feature = "web")]
mod bench;
mod bind;
#[cfg(feature = "web")]
pub mod browser;

#[cfg(feature = "web")]
pub use bench::bench;

use crate::browser as chromium;
use crate::consent;
use crate::run::{is_there, run};
use crate::target;
use anyhow::{Result, bail, ensure};
use std::path::Path;

/// The output folder of the page.
pub const FOLDER: &str = "target/page";
const TARGET: &str = "wasm32-unknown-unknown";
const WASM: &str = "target/wasm32-unknown-unknown/web/canvass_web.wasm";
/// The folder with the parts of the page that are not Rust.
const SOURCE: &str = "web/page";
/// Maximum size of the compressed WebAssembly in bytes, as the page may be sent by mail.
const MOST: u64 = 2_500_000;

/// Makes the page.
///
/// # Errors
/// If a tool is missing, or fails.
pub fn build() -> Result<()> {
    prepare()?;
    run("cargo", &["build", "--package", "canvass-web", "--target", TARGET, "--profile", "web", "--locked"])?;
    bind::bind(WASM, &format!("{FOLDER}/wasm"))?;
    run("node", &[&format!("{SOURCE}/build.mjs"), FOLDER])?;
    let size = std::fs::metadata(format!("{FOLDER}/wasm/canvass_web.wasm.gz"))?.len();
    eprintln!("WebAssembly, compressed: {size} bytes");
    ensure!(size < MOST, "expected less than {MOST} bytes");
    Ok(())
}

/// Fetches the tools for the page.
///
/// # Errors
/// If a tool can't be installed.
pub fn prepare() -> Result<()> {
    let missing = missing();
    ensure!(missing.is_empty(), "the page can't be made: {}", missing.join("; "));
    install()
}

/// Makes the JavaScript for the WebAssembly; [`build`] calls it in an xtask with the feature `bind`.
///
/// # Errors
/// If the words are not a module and a folder, or the JavaScript can't be made.
pub fn bind(words: &[String]) -> Result<()> {
    let [wasm, folder] = words else {
        bail!("web-bind: expected the WebAssembly module and the output folder, found {words:?}")
    };
    bind::bind(wasm, folder)
}

/// Measures the page.
///
/// # Errors
/// If an xtask that can drive a browser can't be built, or its command fails.
#[cfg(not(feature = "web"))]
pub fn bench() -> Result<()> {
    by_another("web", &["web-bench"])
}

/// Runs a command by an xtask with this feature, so that other commands need not wait for its build.
///
/// # Errors
/// If that xtask can't be built, or the command fails.
#[cfg(not(all(feature = "bind", feature = "web")))]
pub fn by_another(feature: &str, words: &[&str]) -> Result<()> {
    let xtask = ["run", "--quiet", "--package", "xtask", "--features", feature, "--locked", "--"];
    run("cargo", &[&xtask[..], consent::words(), words].concat())
}

/// The path of the page as one file.
#[cfg(feature = "web")]
pub fn file() -> Result<std::path::PathBuf> {
    Ok(std::fs::canonicalize(format!("{FOLDER}/canvass.html"))?)
}

/// Makes and tests the page: the same bytes as the program for every sample, and no request in Chromium.
///
/// # Errors
/// If the page can't be made, or a test fails.
pub fn test() -> Result<()> {
    chromium::install_all()?;
    run("cargo", &["build", "--locked", "--bin", "canvass"])?;
    tried(|| run("cargo", &["test", "--locked", "--features", "page", "--test", "page"]))
}

/// Makes the page, and tests it against the program that is already built.
fn tried(in_browser: impl FnOnce() -> Result<()>) -> Result<()> {
    build()?;
    run("node", &["--test", "web/page/tests/equal.test.mjs"])?;
    in_browser()
}

/// The step of CI, with its tests in Chromium. If a tool is missing and can't be installed, the step is left out with a
/// message.
///
/// # Errors
/// As [`test()`].
pub fn step(in_browser: impl FnOnce() -> Result<()>) -> Result<()> {
    let mut missing = missing();
    if let Err(error) = chromium::install_all() {
        missing.push(format!("{error:#}"));
    }
    // Without a network npm can't install packages, which is no fault of the page.
    if missing.is_empty()
        && let Err(error) = install()
    {
        missing.push(format!("{error:#}"));
    }
    if missing.is_empty() {
        return tried(in_browser);
    }
    eprintln!("LEFT OUT: the page was neither made nor tested, because {}", missing.join("; "));
    Ok(())
}

/// The tools that are missing and can't be installed.
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

/// The file that npm writes after an installation.
const INSTALLED: &str = "node_modules/.package-lock.json";
/// The file from which npm installs.
const LOCKED: &str = "package-lock.json";

/// Installs the packages of the lock file, unless they are installed.
fn install() -> Result<()> {
    let changed = |file: &str| Path::new(SOURCE).join(file).metadata().and_then(|known| known.modified()).ok();
    if changed(INSTALLED) > changed(LOCKED) {
        return Ok(());
    }
    consent::ask("what the page is built by", &format!("npm ci --prefix {SOURCE}"))?;
    if run("npm", &["ci", "--no-audit", "--no-fund", "--prefix", SOURCE]).is_err() {
        bail!("npm could not install what {SOURCE}/package-lock.json names");
    }
    Ok(())
}
