//! The cases that pass on devices that do nothing right.

use super::line;
use crate::results::selftest::{FalseAlarm, NullRow as NullResultRow, NullSelftestResult, ReviewedPass};
use crate::results::{self, Contract, Verdict};
use canvass_suite::case::Case;
use canvass_suite::selftest::null::NullRow;
use canvass_suite::verdict::{Kind, Reason};
use std::io::{self, Write};

/// Writes the document, indented, with a line end.
///
/// # Errors
/// The errors of `out`.
pub fn json(rows: &[NullRow], out: &mut dyn Write) -> io::Result<()> {
    let devices = rows.iter().map(device).collect();
    results::write(&NullSelftestResult { devices, schema: NullSelftestResult::SCHEMA.into() }, out)
}

fn device(row: &NullRow) -> NullResultRow {
    let reviewed = row.reviewed.iter();
    NullResultRow {
        counts: Kind::ALL.into_iter().map(|kind| (kind.name().into(), row.counts[kind as usize])).collect(),
        device: row.device.id().into(),
        false_alarms: row.alarms.iter().map(alarm).collect(),
        reviewed: reviewed
            .map(|(case, reason)| ReviewedPass { case: case.id.into(), reason: reason.clone() })
            .collect(),
        stale: row.stale.clone(),
        unexplained: row.unexplained.iter().map(|(case, _)| case.id.into()).collect(),
    }
}

fn alarm((case, kind, reason): &(&'static Case, Kind, Reason)) -> FalseAlarm {
    FalseAlarm { case: case.id.into(), reason: reason.to_string(), verdict: Verdict(*kind) }
}

/// A line for each device, for each pass that the reviewed list does not contain, for each case of the list that did
/// not pass, and for each false alarm; then a summary.
pub fn text(rows: &[NullRow]) -> String {
    let mut text = String::new();
    for row in rows {
        let sign = if row.is_good() { '✓' } else { '✗' };
        let counts = Kind::ALL.into_iter().filter(|kind| row.counts[*kind as usize] > 0);
        let counts: Vec<String> = counts.map(|kind| format!("{} {kind}", row.counts[kind as usize])).collect();
        let (device, reviewed) = (row.device.id(), row.reviewed.len());
        line(&mut text, &format!("{sign} {device}: {}; {reviewed} reviewed passes", counts.join(", ")));
        for (case, kind) in &row.unexplained {
            line(&mut text, &format!("    {}: {kind}, expected a reason in passes.toml, found none", case.id));
        }
        for id in &row.stale {
            line(&mut text, &format!("    {id}: listed in passes.toml, but it does not pass"));
        }
        for (case, kind, reason) in &row.alarms {
            line(&mut text, &format!("    false alarm: {} ends with {kind}: {reason}", case.id));
        }
    }
    let (good, all) = (rows.iter().filter(|row| row.is_good()).count(), rows.len());
    line(&mut text, &format!("{good} of {all} null devices pass only what was reviewed"));
    text
}
