//! Rows of one file, which is read once and only until no more rows are wanted.

use super::emit::{Emitter, Outlet, Wanted};
use super::rows::{self, DecodedFrame, EventsOfFrames, OfFrames};
use super::{ScanError, diagnosed, results};
use crate::capture::{Access, CaptureFile, Reading, Seen, Unreadable};
use crate::devices::Devices;
use crate::table::Table;
use crate::table::captures::{CaptureRow, Captures};
use crate::table::frames::{FrameRow, Frames};
use crate::table::messages::Messages;
use crate::table::signals::Signals;
use canvass_analyzer::network::{Network, Skipping, Steady};
use canvass_tables::event_collector::EventCollector;
use canvass_traces::{Quality, SkipSet, Timestamp};
use std::ops::ControlFlow;

/// The access to files, with the rules of devices.
pub struct Source<'a> {
    /// Opens the files.
    pub access: &'a Access,
    /// The rules of devices.
    pub devices: &'a Devices,
}

/// Outputs the rows of a file; `false` if the file is no readable capture or result.
///
/// # Errors
/// [`ScanError`] if the file or a device description can't be read.
pub fn produce(
    source: &Source<'_>,
    table: Table,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<bool, ScanError> {
    match table {
        Table::Captures => return capture(source, file, wanted, outlet).map(|()| true),
        Table::Runs | Table::Verdicts => return results::produce(source.access, table, file, wanted, outlet),
        _ => {}
    }
    let Ok(reading) = Reading::open(source.access, file, false)? else { return Ok(false) };
    match table {
        Table::Frames => frames(reading, file, wanted, outlet)?,
        Table::Messages => messages(source, reading, file, wanted, outlet)?,
        Table::Signals => signals(source, reading, file, wanted, outlet)?,
        Table::Events => events(source, reading, file, wanted, outlet)?,
        _ => diagnosed::produce(source, reading, table, file, wanted, outlet)?,
    }
    Ok(true)
}

fn capture(
    source: &Source<'_>,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let hashes = wanted.asks::<Captures>("sha256");
    let mut emitter = Emitter::<Captures>::new(wanted, outlet);
    let opened = Reading::open(source.access, file, hashes)?;
    let mut reading = match opened {
        Ok(reading) => reading,
        Err(unreadable) => {
            let _ = unreadable_row(file, &unreadable, |row| emitter.row(row))?;
            return emitter.finish();
        }
    };
    while reading.advance()?.is_some() {
        if emitter.look().is_break() {
            return Ok(());
        }
    }
    let sha256 = reading.sha256(source.access, file)?;
    let _ = emitter.row(&capture_row(file, &reading, sha256.as_deref()))?;
    emitter.finish()
}

/// The row of a capture that was read.
pub fn capture_row<'a>(file: &'a CaptureFile, reading: &'a Reading, sha256: Option<&'a str>) -> CaptureRow<'a> {
    CaptureRow {
        capture: &file.name,
        sha256,
        size: file.size,
        format: reading.format(),
        time_base: Some(reading.time_base()),
        quality: reading.quality(),
        reason: reading.stopped(),
    }
}

/// The row of a file that is no readable capture.
pub fn unreadable_row<T>(file: &CaptureFile, unreadable: &Unreadable, take: impl FnOnce(&CaptureRow<'_>) -> T) -> T {
    let (quality, size) = (&Quality::default(), file.size);
    let (sha256, reason) = (unreadable.sha256.as_deref(), Some(&*unreadable.reason));
    take(&CaptureRow { capture: &file.name, sha256, size, format: None, time_base: None, quality, reason })
}

fn frames(
    mut reading: Reading,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let mut emitter = Emitter::<Frames>::new(wanted, outlet);
    let (mut skip, skips) = (SkipSet::default(), wanted.skips && emitter.may_refuse_alike());
    while let Some(seen) = reading.advance_kept(&mut skip)? {
        if seen == Seen::Damage {
            continue;
        }
        let (record, channels) = (reading.record(), reading.merge().channels());
        let row = FrameRow { capture: &file.name, record, channels };
        if emitter.row(&row)?.is_break() || emitter.skipped(skip.take().0).is_break() {
            break;
        }
        if let (true, Some(alike)) = (skips, Steady::like(&record.frame))
            && emitter.refuses_alike(&row, alike)
        {
            alike.skip(record.channel, &mut skip);
        }
    }
    emitter.finish()
}

/// The state after a capture was decoded to its end: the network, and the time of the last frame if that was skipped.
type AtEnd = (Network, Option<Timestamp>);

/// Decodes a capture and passes each frame to `rows`, until no more rows are wanted.
fn decode(
    source: &Source<'_>,
    reading: &mut Reading,
    file: &CaptureFile,
    skips: bool,
    rows: &mut impl OfFrames,
) -> Result<ControlFlow<(), AtEnd>, ScanError> {
    let mut network = rows::network(source.devices)?;
    let (mut skipping, skips) = (Skipping::default(), skips && rows.may_refuse());
    while let Some(seen) = reading.advance_kept(skipping.set())? {
        if seen == Seen::Damage {
            continue;
        }
        if skips && rows.skipped(skipping.set().take().0).is_break() {
            return Ok(ControlFlow::Break(()));
        }
        let (record, channels) = (reading.record(), reading.merge().channels());
        let decoded = &network.handle(record);
        let Some(bus) = network.bus(record.channel) else { continue };
        let frame = DecodedFrame { capture: &file.name, record, channels, decoded, bus };
        if rows.frame(frame)?.is_break() {
            return Ok(ControlFlow::Break(()));
        }
        if skips {
            skipping.taken(bus, record, decoded, |steady| rows.refuses(frame, steady));
        }
    }
    Ok(ControlFlow::Continue((network, skipping.set().take().1)))
}

fn messages(
    source: &Source<'_>,
    mut reading: Reading,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let mut emitter = Emitter::<Messages>::new(wanted, outlet);
    let _ = decode(source, &mut reading, file, wanted.skips, &mut emitter)?;
    emitter.finish()
}

fn signals(
    source: &Source<'_>,
    mut reading: Reading,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let mut emitter = Emitter::<Signals>::new(wanted, outlet);
    let _ = decode(source, &mut reading, file, wanted.skips, &mut emitter)?;
    emitter.finish()
}

fn events(
    source: &Source<'_>,
    mut reading: Reading,
    file: &CaptureFile,
    wanted: Wanted<'_>,
    outlet: &mut dyn Outlet,
) -> Result<(), ScanError> {
    let mut events = EventsOfFrames { collector: EventCollector::default(), emitter: Emitter::new(wanted, outlet) };
    let decoded = decode(source, &mut reading, file, wanted.skips, &mut events)?;
    let EventsOfFrames { collector, mut emitter } = events;
    if let ControlFlow::Continue((network, skipped)) = decoded {
        let channels = reading.merge().channels();
        collector.finish(&file.name, channels, &network, skipped, |row| emitter.row(row))?;
    }
    emitter.finish()
}
