//! Ctrl-C on a console of Windows: the run ends, the device is put back, the report is written. The console is one that Wine
//! makes on a pseudo-terminal, as it gives programs without a console no such events.

use super::wine::{FOLDER, Prefix};
use anyhow::{Context, Result, bail, ensure};
use nix::pty::openpty;
use serde_json::Value;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::process::{Child, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A run that does not end by itself in that time.
const RUN: [&str; 6] = ["test", "sim:reference-301", "--exhaustive", "--repeat", "1000", "--report"];
/// When the user presses the keys. A busy machine has not begun the run after the first of these.
const AFTER: [Duration; 3] = [Duration::from_secs(4), Duration::from_secs(15), Duration::from_secs(45)];
/// How long what follows may take.
const PATIENCE: Duration = Duration::from_secs(60);

/// Presses it.
///
/// # Errors
/// If the run does not end as it should.
pub fn press(prefix: &Prefix, program: &str) -> Result<()> {
    let report = Path::new(FOLDER).join("interrupted.json");
    for after in AFTER {
        let _ = std::fs::remove_file(&report);
        // Keys that were pressed before anybody listened are lost.
        let Some(status) = interrupted(prefix, program, &report, after)? else { continue };
        let Ok(text) = std::fs::read_to_string(&report) else { continue };
        let document: Value = serde_json::from_str(&text).context("expected the report of an interrupted run")?;
        let cancelled = document["cases"].as_array().and_then(|cases| cases.last()).context("expected a case")?;
        ensure!(status.code() == Some(1), "expected status 1 of an interrupted run, found {status}");
        ensure!(
            cancelled["verdict"] == "inconclusive",
            "expected the case under way to be cancelled, found {cancelled}"
        );
        eprintln!(
            "Ctrl-C on a console: the run ended after {} cases, with its report",
            document["cases"].as_array().map_or(0, Vec::len)
        );
        return Ok(());
    }
    bail!("expected a report of a run that Ctrl-C has ended, found none")
}

fn interrupted(prefix: &Prefix, program: &str, report: &Path, after: Duration) -> Result<Option<ExitStatus>> {
    let terminal = openpty(None, None).context("a pseudo-terminal")?;
    let side = || terminal.slave.try_clone().map(Stdio::from);
    let report = format!("json={}", report.display());
    let mut wine = prefix.wine(&[&[program], &RUN[..], &[&report]].concat());
    let mut running = wine.stdin(side()?).stdout(side()?).stderr(side()?).spawn().context("wine")?;
    let mut keys = File::from(terminal.master);
    let mut shown = keys.try_clone()?;
    // Nobody looks at it; a console that nobody reads waits.
    std::thread::spawn(move || std::io::copy(&mut shown, &mut std::io::sink()));
    std::thread::sleep(after);
    keys.write_all(b"\x03")?;
    ended(&mut running)
}

/// How it ended; `None` if it did not by itself.
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
