//! The cases whose verdict in a whole run differs from their verdict when they run alone.

use super::line;
use crate::results::selftest::{AloneDifference, AloneFirmware, AloneSelftestResult};
use crate::results::{self, Contract, Verdict};
use canvass_suite::selftest::alone::{AloneRow, Difference, Order};
use std::io::{self, Write};

/// Writes the document, indented, with a line end.
///
/// # Errors
/// The errors of `out`.
pub fn json(rows: &[AloneRow], out: &mut dyn Write) -> io::Result<()> {
    let firmwares = rows.iter().map(firmware).collect();
    results::write(&AloneSelftestResult { firmwares, schema: AloneSelftestResult::SCHEMA.into() }, out)
}

fn firmware(row: &AloneRow) -> AloneFirmware {
    let explained = row.explained.iter().map(|(difference, reason)| told(difference, Some(reason)));
    AloneFirmware {
        cases: row.cases,
        explained: explained.collect(),
        firmware: row.subject.to_string(),
        unexplained: row.unexplained.iter().map(|difference| told(difference, None)).collect(),
    }
}

fn told(difference: &Difference, explanation: Option<&str>) -> AloneDifference {
    AloneDifference {
        alone: Verdict(difference.alone),
        case: difference.case.id.into(),
        explanation: explanation.map(str::to_owned),
        reasons: difference.reasons.to_vec(),
        shuffled: difference.order == Order::Shuffled,
        together: difference.together.map(Verdict),
    }
}

/// A line for each firmware with differences, a line for each of its differences that is not explained, and a summary.
pub fn text(rows: &[AloneRow]) -> String {
    let mut text = String::new();
    for row in rows.iter().filter(|row| !row.explained.is_empty() || !row.unexplained.is_empty()) {
        let sign = if row.is_good() { '✓' } else { '✗' };
        let (explained, unexplained) = (row.explained.len(), row.unexplained.len());
        line(
            &mut text,
            &format!("{sign} {}: {explained} differences explained, {unexplained} unexplained", row.subject),
        );
        row.unexplained.iter().for_each(|difference| line(&mut text, &sentence(difference)));
    }
    let verdicts: usize = rows.iter().map(|row| 2 * row.cases).sum();
    let explained: usize = rows.iter().map(|row| row.explained.len()).sum();
    let unexplained: usize = rows.iter().map(|row| row.unexplained.len()).sum();
    line(
        &mut text,
        &format!(
            "{} firmwares, {verdicts} verdicts in whole runs: {} as alone, {explained} explained by a defect, \
             {unexplained} unexplained",
            rows.len(),
            verdicts - explained - unexplained
        ),
    );
    text
}

fn sentence(difference: &Difference) -> String {
    let together = difference.together.map_or_else(|| "not run".to_owned(), |kind| kind.to_string());
    let order = if difference.order == Order::Shuffled { "shuffled" } else { "together" };
    let [alone, whole] = &difference.reasons;
    format!("    {}: alone {} ({alone}), {order} {together} ({whole})", difference.case.id, difference.alone)
}
