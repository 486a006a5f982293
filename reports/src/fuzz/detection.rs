//! The time in which the fuzzer finds each fault, as a table in text or JSON ([`FuzzSelftestResult`]).

use crate::results::selftest::{FuzzSelftestResult, FuzzSummary, Trial};
use crate::results::{self, Contract};
use canvass_fuzzer::detection::{self, FuzzedFault, Table};
use std::fmt::Write as _;
use std::io::{self, Write};
use std::time::Duration;

/// The table for people. A line for each fault has the median and the longest time of all seeds, the median and the
/// largest number of frames of the shortened sequences, and the violated property.
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

/// The table as JSON.
///
/// # Errors
/// The errors of `out`.
pub fn json(table: &Table, out: &mut dyn Write) -> io::Result<()> {
    let result = FuzzSelftestResult {
        faults: table.rows.iter().map(|one| row(one, table.limit)).collect(),
        schema: FuzzSelftestResult::SCHEMA.into(),
        summary: FuzzSummary {
            detected: table.rows.iter().filter(|row| row.is_good(table.limit)).count(),
            faults: table.rows.len(),
            median_frames: table.median_frames(),
            median_ns: table.median_time().map(nanos),
        },
    };
    results::write(&result, out)
}

fn row(row: &FuzzedFault, limit: Duration) -> results::selftest::FuzzedFault {
    results::selftest::FuzzedFault {
        allow: row.fault.fuzz_needs().map(Into::into),
        fault: row.fault.id().into(),
        good: row.is_good(limit),
        model: row.fault.model().into(),
        trials: row.trials.iter().map(trial).collect(),
    }
}

fn trial(trial: &detection::Trial) -> Trial {
    let detected = trial.found.as_ref();
    let found = detected.map(|detected| &detected.found);
    Trial {
        caused: detected.map(|detected| detected.caused),
        confirmed: found.map(|found| found.confirmed),
        elapsed_ns: detected.map(|detected| nanos(detected.elapsed)),
        exchanges: trial.exchanges,
        frames: found.map(|found| found.sequence.stimuli.len()),
        property: found.map(|found| found.violation.property.id().into()),
        rule: found.map(|found| found.violation.rule.into()),
        seed: trial.seed,
    }
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
