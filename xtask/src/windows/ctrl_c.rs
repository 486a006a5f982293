//! Ctrl-C on a console of Windows: the run ends, the device is restored, the report is written. Wine makes the console
//! on a pseudo-terminal, as it sends no such events to programs without a console.

use super::wine::{FOLDER, Prefix};
use anyhow::{Context, Result, bail, ensure};
use nix::pty::openpty;
use serde_json::Value;
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// The arguments of a run that does not end by itself within the time limit.
const RUN: [&str; 6] = ["test", "sim:reference-301", "--exhaustive", "--repeat", "1000", "--report"];
/// The text that the console shows after the first passed case. Ctrl-C comes after this text, as a run without any
/// verdict has another exit status.
const RUNNING: &str = "301/cob-id/";
/// Time limit on a busy machine until the console shows [`RUNNING`].
const BEGIN: Duration = Duration::from_secs(180);
/// Time limit for the end of the run after Ctrl-C.
const PATIENCE: Duration = Duration::from_secs(120);
/// Number of characters of the console's output in an error message.
const TOLD: usize = 2_000;

/// Presses Ctrl-C during a run.
///
/// # Errors
/// If the run does not end as expected.
pub fn press(prefix: &Prefix, program: &str) -> Result<()> {
    let report = Path::new(FOLDER).join("interrupted.json");
    let _ = std::fs::remove_file(&report);
    let Interrupted { status, shown } = interrupted(prefix, program, &report)?;
    let text = std::fs::read_to_string(&report);
    let text = text.with_context(|| format!("expected a report of the run, which ended with {status}: {shown}"))?;
    let document: Value = serde_json::from_str(&text).context("expected the report of an interrupted run")?;
    ensure!(status.code() == Some(1), "expected status 1 of an interrupted run, found {status}: {shown}");
    // Ctrl-C may come between two cases.
    ensure!(document["cancelled"] == true, "expected a run that was cancelled, found {}", document["summary"]);
    eprintln!(
        "Ctrl-C on a console: the run ended after {} cases, with its report",
        document["cases"].as_array().map_or(0, Vec::len)
    );
    Ok(())
}

/// An interrupted run, with the last output of its console.
struct Interrupted {
    status: ExitStatus,
    shown: String,
}

fn interrupted(prefix: &Prefix, program: &str, report: &Path) -> Result<Interrupted> {
    let terminal = openpty(None, None).context("a pseudo-terminal")?;
    let side = || terminal.slave.try_clone().map(Stdio::from);
    let report = format!("json={}", report.display());
    let mut wine = prefix.wine_on_terminal(&[&[program], &RUN[..], &[&report]].concat());
    let mut running = wine.stdin(side()?).stdout(side()?).stderr(side()?).spawn().context("wine")?;
    let mut keys = File::from(terminal.master);
    let shown = Arc::new(Mutex::new(String::new()));
    // The program would block if nothing read its console.
    let (from, to) = (keys.try_clone()?, Arc::clone(&shown));
    std::thread::spawn(move || read(from, &to));
    let told = || {
        let shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        let from = shown.char_indices().rev().nth(TOLD).map_or(0, |(at, _)| at);
        shown.get(from..).unwrap_or_default().to_owned()
    };
    // Keys pressed before the program reads them are lost.
    let is_running = || shown.lock().unwrap_or_else(PoisonError::into_inner).contains(RUNNING);
    let begun = Instant::now();
    while !is_running() {
        if let Some(status) = running.try_wait()? {
            bail!("the run ended with {status} before Ctrl-C was pressed; its output: {}", told());
        }
        if begun.elapsed() > BEGIN {
            running.kill()?;
            running.wait()?;
            bail!("expected {RUNNING} on the console within {BEGIN:?}, found {}", told());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    keys.write_all(b"\x03")?;
    match ended(&mut running)? {
        Some(status) => Ok(Interrupted { status, shown: told() }),
        None => bail!("expected the run to end within {PATIENCE:?} after Ctrl-C, found {}", told()),
    }
}

/// Reads the output of the console until it is closed.
fn read(mut console: File, shown: &Mutex<String>) {
    let mut buffer = [0; 4096];
    while let Ok(length @ 1..) = console.read(&mut buffer) {
        let text = String::from_utf8_lossy(buffer.get(..length).unwrap_or_default());
        shown.lock().unwrap_or_else(PoisonError::into_inner).push_str(&text);
    }
}

/// Waits for the end of the run; `None` if it did not end by itself.
fn ended(running: &mut Child) -> Result<Option<ExitStatus>> {
    let begun = Instant::now();
    while begun.elapsed() < PATIENCE {
        if let Some(status) = running.try_wait()? {
            return Ok(Some(status));
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    running.kill()?;
    running.wait()?;
    Ok(None)
}
