//! The picture of the page of a diagnosis in `docs/diagnose.md`: an encoder that loses its supply, and what follows.

use crate::browser;
use crate::measure::release;
use crate::run::run;
use anyhow::{Context, Result, ensure};
use std::fmt::Write;
use std::fs;
use std::process::{Command, Stdio};

const FOLDER: &str = "target/screenshot";
const PICTURE: &str = "docs/diagnose.png";
/// The head of the page, and its timeline.
const SIZE: &str = "--window-size=1100,815";
/// A picture that is looked at in a document.
const MOST: u64 = 150 * 1024;

/// Takes the picture.
///
/// # Errors
/// If a program can't be run, the first finding is not the loss of the encoder, or the picture is too large.
pub fn screenshot() -> Result<()> {
    browser::install_all()?;
    run("cargo", &["build", "--release", "--locked"])?;
    fs::create_dir_all(FOLDER)?;
    let (capture, page) = (format!("{FOLDER}/machine.log"), format!("{FOLDER}/page.html"));
    fs::write(&capture, machine()?)?;
    let canvass = release("canvass");
    let told = Command::new(&canvass).args(["diagnose", "--fail-on", "never", &capture]).output()?;
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    let first = told.lines().next().unwrap_or_default();
    ensure!(first.contains("node 5") && first.contains("nodes/lost"), "the story begins with \"{first}\"");
    let html = ["--format", "html", "--bit-rate", "125k", "--fail-on", "never", "--output", &page];
    run(&canvass, &[&["diagnose", &capture], &html[..]].concat())?;
    photograph(&page)
}

/// Without a window; time goes on at once, so that the page is drawn.
fn photograph(page: &str) -> Result<()> {
    let url = format!("file://{}", fs::canonicalize(page)?.display());
    let chromium = Command::new("chromium")
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", "--virtual-time-budget=5000"])
        .args([SIZE, &format!("--screenshot={PICTURE}"), &url])
        .stderr(Stdio::null())
        .status()
        .context("can't run chromium")?;
    ensure!(chromium.success(), "chromium ended with {chromium}");
    let size = fs::metadata(PICTURE)?.len();
    ensure!(size < MOST, "{PICTURE} has {size} bytes");
    println!("{PICTURE}: {size} bytes");
    Ok(())
}

/// Half a minute: node 5 is without supply from 12 to 20.3 s; node 2 misses its heartbeat and stops; two resets.
fn machine() -> Result<String> {
    let mut frames: Vec<(u64, String)> = [
        (211, "702#00"),
        (217, "705#00"),
        (223, "707#00"),
        (300, "605#2B171000F4010000"),
        (302, "585#6017100000000000"),
        (310, "602#23161001DC050500"),
        (312, "582#6016100100000000"),
        (800, "000#0100"),
        (13_530, "082#3081110000000000"),
        (14_200, "605#4041600000000000"),
        (15_000, "000#8105"),
        (16_500, "605#8041600000000405"),
        (18_000, "000#8105"),
        (20_300, "705#00"),
        (20_900, "000#0105"),
        (22_000, "082#0000000000000000"),
        (22_400, "000#0102"),
    ]
    .map(|(at, frame)| (at, frame.to_owned()))
    .to_vec();
    let (lost, stopped) = (12_000..20_500, 13_600..22_500);
    for at in (0..30_000).step_by(500) {
        let state = |is_waiting: bool| if at < 1_000 || is_waiting { "7F" } else { "05" };
        frames.push((at + 3, "701#05".to_owned()));
        if at > 0 {
            frames.push((at + 11, format!("702#{}", state(stopped.contains(&at)))));
            frames.push((at + 23, format!("707#{}", state(false))));
        }
        if at > 0 && !lost.contains(&at) {
            frames.push((at + 17, format!("705#{}", state(at < 21_000 && at > lost.end - 1))));
        }
    }
    for at in (1_000..30_000).step_by(20) {
        let [low, high, ..] = (at / 20 * 37_u64).to_le_bytes();
        frames.push((at, "080#".to_owned()));
        frames.push((at + 3, format!("187#{low:02X}")));
        if !(lost.start..21_000).contains(&at) {
            frames.push((at + 1, format!("185#{low:02X}{high:02X}0000")));
        }
        if !stopped.contains(&at) {
            frames.push((at + 2, format!("182#{low:02X}0200")));
        }
    }
    frames.sort();
    let mut log = String::new();
    for (at, frame) in frames {
        writeln!(log, "({}.{:03}000) can0 {frame}", 1_700_000_000 + at / 1_000, at % 1_000)?;
    }
    Ok(log)
}
