//! Tables that need a whole capture: findings, nodes and statistics come from one diagnosis.

use super::ScanError;
use super::emit::{Emitter, Outlet, Wanted};
use super::produce::Source;
use crate::capture::{CaptureFile, Reading, Seen};
use crate::devices::Devices;
use crate::table::Table;
use crate::table::findings::{FindingRow, Findings};
use crate::table::nodes::{NodeRow, Nodes};
use crate::table::statistics::{Statistics, StatisticsRow};
use canvass_analyzer::Service;
use canvass_analyzer::findings::{Diagnosis, Results, SourceQuality, Thresholds};
use canvass_reports::diagnosis::{self, Diagnosed};
use canvass_reports::provenance::Provenance;
use canvass_reports::quality::CaptureQuality;
use canvass_traces::Channels;

/// Diagnoses a capture and outputs the rows of a table.
///
/// # Errors
/// As [`super::produce::produce`].
pub fn produce(
    source: &Source<'_>,
    mut reading: Reading,
    table: Table,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let Some(results) = diagnose(source, &mut reading, outlet)? else { return Ok(()) };
    give(table, &results, &reading, file, wanted, outlet)
}

/// The results of a capture; `None` if no more rows are wanted.
fn diagnose(source: &Source<'_>, reading: &mut Reading, outlet: &dyn Outlet) -> Result<Option<Results>, ScanError> {
    let mut diagnosing = Diagnosing::new(source.devices)?;
    let mut unlooked = 0_u32;
    while let Some(seen) = reading.advance()? {
        unlooked += 1;
        if unlooked.is_multiple_of(8192) && !outlet.is_wanted() {
            return Ok(None);
        }
        diagnosing.take(seen, reading)?;
    }
    Ok(Some(diagnosing.finish(reading)?))
}

/// A diagnosis in progress.
pub struct Diagnosing {
    in_order: diagnosis::Reading,
    /// Whether there was damage since the last record.
    is_damaged: bool,
}

impl Diagnosing {
    /// Begins a diagnosis with the rules of devices.
    ///
    /// # Errors
    /// If a description can't be read.
    pub fn new(devices: &Devices) -> Result<Self, ScanError> {
        let mut diagnosis = Diagnosis::new(Thresholds::default());
        let mut offered = None;
        devices.tell(|node, known| diagnosis.describe(node, known), |candidates| offered = Some(candidates))?;
        diagnosis.offer(offered.unwrap_or_default());
        Ok(Self { in_order: diagnosis::Reading::new(diagnosis, None), is_damaged: false })
    }

    /// Passes the latest item of the capture to the diagnosis. A record is moved out of `reading`.
    ///
    /// # Errors
    /// The errors of `diagnosis::Reading`. They come from the collector of an HTML report, which is not made here.
    pub fn take(&mut self, seen: Seen, reading: &mut Reading) -> Result<(), ScanError> {
        self.is_damaged |= seen != Seen::Record;
        if seen == Seen::Damage {
            return Ok(());
        }
        if std::mem::take(&mut self.is_damaged) {
            self.in_order.interrupted(reading.merge())?;
        }
        self.in_order.see_channel(reading.record().channel, reading.merge());
        // A frame that contradicts itself is no evidence.
        if seen == Seen::Record {
            reading.hand_over(&mut self.in_order)?;
        }
        Ok(())
    }

    /// The results of the diagnosis.
    ///
    /// # Errors
    /// As [`Diagnosing::take`].
    pub fn finish(self, reading: &Reading) -> Result<Results, ScanError> {
        let (quality, name) = (reading.quality(), reading.merge().name(0));
        Ok(self.in_order.finish(reading.merge(), &[SourceQuality { name, quality }])?.0)
    }
}

/// Outputs the rows of a table from the results of a capture.
///
/// # Errors
/// As [`Emitter::row`].
pub fn give(
    table: Table,
    results: &Results,
    reading: &Reading,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let channels = reading.merge().channels();
    match table {
        Table::Findings => {
            let captures = reading.merge().sources().map(|capture| CaptureQuality::new(capture, reading.quality()));
            let (captures, provenance) = (captures.collect::<Vec<_>>(), Provenance::default());
            let diagnosed = &Diagnosed { results, channels, captures: &captures, provenance: &provenance };
            findings(diagnosed, file, Emitter::new(wanted, outlet))
        }
        Table::Nodes => nodes(results, channels, file, Emitter::new(wanted, outlet)),
        _ => statistics(results, channels, file, Emitter::new(wanted, outlet)),
    }
}

fn findings(
    diagnosed: &Diagnosed<'_>,
    file: &CaptureFile,
    mut emitter: Emitter<'_, Findings>,
) -> Result<(), ScanError> {
    for finding in &diagnosed.results.findings {
        if emitter.row(&FindingRow { capture: &file.name, diagnosed, finding })?.is_break() {
            break;
        }
    }
    emitter.finish()
}

fn nodes(
    results: &Results,
    channels: &Channels,
    file: &CaptureFile,
    mut emitter: Emitter<'_, Nodes>,
) -> Result<(), ScanError> {
    for (channel, bus) in &results.buses {
        let channel = channels.name(*channel);
        for (id, node) in &bus.nodes {
            if emitter.row(&NodeRow { capture: &file.name, channel, id: *id, node, bus })?.is_break() {
                return emitter.finish();
            }
        }
    }
    emitter.finish()
}

fn statistics(
    results: &Results,
    channels: &Channels,
    file: &CaptureFile,
    mut emitter: Emitter<'_, Statistics>,
) -> Result<(), ScanError> {
    for (channel, bus) in &results.buses {
        let channel = channels.name(*channel);
        let seen = Service::ALL.into_iter().filter(|service| bus.frames[*service as usize] > 0).map(Some);
        for service in std::iter::once(None).chain(seen) {
            if emitter.row(&StatisticsRow { capture: &file.name, channel, bus, service })?.is_break() {
                return emitter.finish();
            }
        }
    }
    emitter.finish()
}
