//! How fast the fuzzer finds which fault: a table, text or JSON (`"schema": "canvass/selftest-fuzz/1"`).

use canvass_fuzzer::detection::{FuzzedFault, Table};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::time::Duration;

/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/selftest-fuzz/1";

/// The table for people: a line for each fault with the time to find it, median and longest of all seeds, the frames of
/// the minimal sequence, and what showed it.
pub fn text(table: &Table) -> String {
    let mut text = String::new();
    for row in &table.rows {
        let sign = if row.is_good(table.limit) { '✓' } else { '✗' };
        let (seeds, found) = (row.trials.len(), row.found().count());
        let times = format!("{:>7} {:>7}", milliseconds(row.median_time()), milliseconds(row.longest_time()));
        let shown = row.found().next().map(|detected| {
            let violation = &detected.found.violation;
            let allowed = row.fault.fuzz_needs().map(|touch| format!(" (allowed: {touch})")).unwrap_or_default();
            let alarm = match row.found().all(|detected| detected.caused) {
                true => "",
                false => ", which shows without the fault too",
            };
            format!("{} {}{alarm}{allowed}", violation.property, violation.rule)
        });
        let frames = row.median_frames().map_or_else(|| "-".to_owned(), |frames| frames.to_string());
        let most = row.most_frames().map_or_else(|| "-".to_owned(), |frames| frames.to_string());
        line(
            &mut text,
            &format!(
                "{sign} {:44} {found}/{seeds} {times} ms {frames:>3} {most:>3} frames  {}",
                row.fault.id(),
                shown.unwrap_or_default()
            ),
        );
    }
    let good = table.rows.iter().filter(|row| row.is_good(table.limit)).count();
    line(&mut text, &format!("{good} of {} faults found with every seed", table.rows.len()));
    if let (Some(time), Some(frames)) = (table.median_time(), table.median_frames()) {
        line(
            &mut text,
            &format!(
                "median {} ms and {frames} frames; longest {} ms, most frames {}",
                milliseconds(Some(time)),
                milliseconds(table.longest_time()),
                table.most_frames().unwrap_or(0)
            ),
        );
    }
    text
}

/// The same for programs.
pub fn json(table: &Table) -> Value {
    json!({
        "schema": SCHEMA,
        "summary": {
            "faults": table.rows.len(),
            "detected": table.rows.iter().filter(|row| row.is_good(table.limit)).count(),
            "median_ns": table.median_time().map(nanos),
            "median_frames": table.median_frames(),
        },
        "faults": table.rows.iter().map(|one| row(one, table.limit)).collect::<Vec<_>>(),
    })
}

fn row(row: &FuzzedFault, limit: Duration) -> Value {
    let trials = row.trials.iter().map(|trial| {
        json!({
            "seed": trial.seed,
            "exchanges": trial.exchanges,
            "elapsed_ns": trial.found.as_ref().map(|detected| nanos(detected.elapsed)),
            "caused": trial.found.as_ref().map(|detected| detected.caused),
            "confirmed": trial.found.as_ref().map(|detected| detected.found.confirmed),
            "frames": trial.found.as_ref().map(|detected| detected.found.sequence.stimuli.len()),
            "property": trial.found.as_ref().map(|detected| detected.found.violation.property.id()),
            "rule": trial.found.as_ref().map(|detected| detected.found.violation.rule),
        })
    });
    json!({
        "fault": row.fault.id(),
        "model": row.fault.model(),
        "allow": row.fault.fuzz_needs(),
        "good": row.is_good(limit),
        "trials": trials.collect::<Vec<_>>(),
    })
}

fn nanos(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

fn milliseconds(time: Option<Duration>) -> String {
    time.map_or_else(|| "-".to_owned(), |time| format!("{:.1}", time.as_secs_f64() * 1e3))
}

fn line(text: &mut String, line: &str) {
    // Writing to a string can't fail.
    let _ = writeln!(text, "{line}");
}
