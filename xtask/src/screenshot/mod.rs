//! The pictures in the documentation: pages of a diagnosis, a run of the suite, a history and a device description;
//! each view of the page with the decoder as WebAssembly; outputs about descriptions on a terminal and in an editor.

mod descriptions;
mod machine;
mod terminal;
#[cfg(feature = "web")]
mod views;

use crate::browser;
use crate::measure::release;
use crate::run::run;
use anyhow::{Context, Result, bail, ensure};
use machine::machine;
use std::fs;
use std::process::{Command, Stdio};
#[cfg(feature = "web")]
use views::views;

const FOLDER: &str = "target/screenshot";
/// Maximum size in bytes of a picture in a document.
const MOST: u64 = 220 * 1024;

/// The releases of the history, some with faults, and the releases that fix them.
const RELEASES: [(&str, &str); 5] = [
    ("1.0", ""),
    ("1.1", "+boot-up-twice"),
    ("1.2", "+boot-up-twice+sdo-toggle-unchecked"),
    ("1.3", "+sdo-toggle-unchecked"),
    ("2.0", ""),
];

/// A function that takes some of the pictures.
type Maker = fn() -> Result<()>;
const MAKERS: [(&str, Maker); 5] = [
    ("diagnosis", diagnosis),
    ("conformance", conformance),
    ("history", history),
    ("descriptions", descriptions::descriptions),
    ("views", views),
];

/// Takes the pictures with these names, or all.
///
/// # Errors
/// If a program can't be run, a page is not the expected one, or a picture is too large.
pub fn screenshot(names: &[String]) -> Result<()> {
    if let Some(unknown) = names.iter().find(|name| MAKERS.iter().all(|(known, _)| known != name)) {
        bail!("expected some of {}, found {unknown}", MAKERS.map(|(name, _)| name).join(", "));
    }
    browser::install_all()?;
    run("cargo", &["build", "--release", "--locked"])?;
    fs::create_dir_all(FOLDER)?;
    let wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    MAKERS.into_iter().filter(|(name, _)| wanted(name)).try_for_each(|(_, make)| make())
}

/// Takes pictures of a diagnosis of an encoder that loses its supply: the head of the page, and the timeline.
fn diagnosis() -> Result<()> {
    let (capture, page) = (format!("{FOLDER}/machine.log"), format!("{FOLDER}/page.html"));
    fs::write(&capture, machine()?)?;
    let told = Command::new(release("canvass")).args(["diagnose", "--fail-on", "never", &capture]).output()?;
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    let first = told.lines().next().unwrap_or_default();
    ensure!(first.contains("node 5") && first.contains("nodes/lost"), "the story begins with \"{first}\"");
    let html = ["--format", "html", "--bit-rate", "125k", "--fail-on", "never", "--output", &page];
    run(&release("canvass"), &[&["diagnose", &capture], &html[..]].concat())?;
    photograph(&page, "docs/diagnose.png", (1100, 815))
}

/// Takes a picture of a failed case with its recording.
fn conformance() -> Result<()> {
    let (recording, page) = (format!("{FOLDER}/run.pcapng"), format!("{FOLDER}/run.html"));
    let report = format!("html={page}");
    let device = ["test", "sim:kuebler-sendix-58x8+boot-up-twice", "--select", "301/boot-up/reset-node"];
    tested(&[&device[..], &["--record", &recording, "--force", "--report", &report]].concat())?;
    photograph(&page, "docs/test.png", (1000, 1400))
}

/// Takes a picture of the history of a device's releases.
fn history() -> Result<()> {
    let page = format!("{FOLDER}/history.html");
    let files = releases()?;
    let files: Vec<&str> = files.iter().map(String::as_str).collect();
    tested(&[&["history"], &files[..], &["--report", &format!("html={page}")]].concat())?;
    photograph(&page, "docs/history.png", (1000, 800))
}

/// Makes a result of each release.
fn releases() -> Result<Vec<String>> {
    let mut files = Vec::new();
    for (release, faults) in RELEASES {
        let file = format!("{FOLDER}/{release}.json");
        let (bus, report) = (format!("sim:reference-301{faults}"), format!("json={file}"));
        tested(&["test", &bus, "--select", "301/boot-up,301/sdo", "--report", &report])?;
        files.push(file);
    }
    Ok(files)
}

/// Takes pictures of the views of the page with the decoder as WebAssembly, by an xtask that can drive a browser.
#[cfg(not(feature = "web"))]
fn views() -> Result<()> {
    crate::web::by_another("web", &["screenshot", "views"])
}

/// Runs canvass, which may end with findings.
fn tested(args: &[&str]) -> Result<()> {
    let ended = Command::new(release("canvass")).args(args).output()?;
    let status = ended.status.code();
    ensure!(
        status.is_some_and(|status| status < 2),
        "canvass {args:?} ended with {}: {}",
        ended.status,
        String::from_utf8_lossy(&ended.stderr)
    );
    Ok(())
}

/// Takes a picture of a page without a window; virtual time passes at once, so that the page is drawn.
fn photograph(page: &str, picture: &str, (width, height): (u16, u16)) -> Result<()> {
    let url = format!("file://{}", fs::canonicalize(page)?.display());
    let chromium = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=5000"])
        .args([&format!("--window-size={width},{height}"), &format!("--screenshot={picture}"), &url])
        .stderr(Stdio::null())
        .status()
        .context("can't run chromium")?;
    ensure!(chromium.success(), "chromium ended with {chromium}");
    ensure_small(picture)
}

fn ensure_small(picture: &str) -> Result<()> {
    let size = fs::metadata(picture)?.len();
    ensure!(size < MOST, "{picture} has {size} bytes");
    println!("{picture}: {size} bytes");
    Ok(())
}
