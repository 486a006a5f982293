//! Turns frames into rows.

use super::Sheet;
use super::columns::{Columns, Place};
use super::dropped::Dropped;
use canvass_analyzer::{Meaning, Message, NodeId, Number, PdoNumber, network::Decoded};
use canvass_traces::{Channels, Duration, Record, Timestamp};
use std::io;

/// A row with its new values.
pub struct SampleRow<'a> {
    pub time: Timestamp,
    /// The PDO of the row. `None` if rows come at fixed times.
    pub source: Option<Origin<'a>>,
    /// The columns that have new values since the row before.
    pub changed: &'a [(usize, Number)],
}

/// The origin of a row: a PDO.
#[derive(Clone, Copy)]
pub struct Origin<'a> {
    /// The channel's name.
    pub channel: &'a str,
    /// The node that the PDO belongs to.
    pub node: NodeId,
    /// The number of the PDO.
    pub pdo: PdoNumber,
}

/// Takes decoded frames and passes rows to a sheet.
pub struct Sampler {
    every: Option<Duration>,
    columns: Columns,
    dropped: Dropped,
    /// The time of the next row, if rows come at fixed times.
    due: Option<Timestamp>,
    latest: Option<Timestamp>,
    changed: Vec<(usize, Number)>,
    /// Number of long silences without rows.
    skipped: u64,
}

/// Number of rows without a PDO after which a silence is left out: the clock has jumped, or the network was off.
const LONGEST_SILENCE: u64 = 100_000;

impl Sampler {
    /// A sampler with one row for each PDO, or with rows at the interval `every` that have the latest values.
    pub fn new(every: Option<Duration>) -> Self {
        let every = every.map(|every| Duration(every.nanos().max(1)));
        let (columns, dropped) = (Columns::default(), Dropped::default());
        Self { every, columns, dropped, due: None, latest: None, changed: Vec::new(), skipped: 0 }
    }

    /// The columns so far.
    pub const fn columns(&self) -> &Columns {
        &self.columns
    }

    /// The mapped values that no row has.
    pub const fn dropped(&self) -> &Dropped {
        &self.dropped
    }

    /// Number of long silences that were left out.
    pub const fn skipped(&self) -> u64 {
        self.skipped
    }

    /// Takes a decoded frame.
    ///
    /// # Errors
    /// The errors of [`Sheet::row`].
    pub fn frame(
        &mut self,
        record: &Record,
        channels: &Channels,
        decoded: &Decoded,
        meaning: &Meaning<'_>,
        sheet: &mut dyn Sheet,
        out: &mut Vec<u8>,
    ) -> io::Result<()> {
        let (Message::Pdo(pdo) | Message::Mpdo(pdo, _)) = decoded.message else { return Ok(()) };
        let Some(node) = decoded.node else { return Ok(()) };
        self.dropped.note(record, decoded, pdo, meaning);
        self.until(record.timestamp, sheet, out)?;
        if self.every.is_none() {
            self.changed.clear();
        }
        let channel_name = channels.name(record.channel);
        let before = self.changed.len();
        for signal in meaning.signals() {
            let place = |scaled| Place { channel: record.channel, channel_name, node, signal: &signal, scaled };
            if let Some((number, unit)) = signal.value() {
                let column = self.columns.of(&place(false), number, unit.as_ref().map_or("", |unit| &unit.symbol));
                self.changed.extend(column.map(|column| (column, number)));
            }
            if let Some((number, unit)) = signal.scaled() {
                let column = self.columns.of(&place(true), number, &unit.symbol);
                self.changed.extend(column.map(|column| (column, number)));
            }
        }
        if self.changed.len() == before {
            return Ok(());
        }
        self.latest = Some(record.timestamp);
        if self.every.is_some() {
            self.due.get_or_insert(record.timestamp);
            return Ok(());
        }
        let source = Some(Origin { channel: channel_name, node, pdo });
        let row = SampleRow { time: record.timestamp, source, changed: &self.changed };
        sheet.row(&row, &self.columns, out)
    }

    /// Passes on the last row, if rows come at fixed times.
    ///
    /// # Errors
    /// The errors of [`Sheet::row`].
    pub fn finish(&mut self, sheet: &mut dyn Sheet, out: &mut Vec<u8>) -> io::Result<()> {
        let after_all = self.latest.map(|latest| latest + Duration(1));
        after_all.map_or(Ok(()), |after_all| self.until(after_all, sheet, out))
    }

    /// Passes on the rows that are due before `now`.
    fn until(&mut self, now: Timestamp, sheet: &mut dyn Sheet, out: &mut Vec<u8>) -> io::Result<()> {
        let (Some(every), Some(mut due)) = (self.every, self.due) else { return Ok(()) };
        if self.latest.is_some_and(|latest| now < latest) {
            // The clock has stepped back, so the times of rows begin anew.
            (self.due, self.latest) = (Some(now), Some(now));
            return Ok(());
        }
        if (now - due).nanos() / every.nanos() > LONGEST_SILENCE {
            self.give(due, sheet, out)?;
            self.skipped += 1;
            // The times of later rows are the same as if no row had been left out.
            let steps = (now - due).nanos().div_ceil(every.nanos());
            self.due = Some(due + every.times(steps));
            return Ok(());
        }
        while due < now {
            self.give(due, sheet, out)?;
            due += every;
        }
        self.due = Some(due);
        Ok(())
    }

    fn give(&mut self, time: Timestamp, sheet: &mut dyn Sheet, out: &mut Vec<u8>) -> io::Result<()> {
        let row = SampleRow { time, source: None, changed: &self.changed };
        sheet.row(&row, &self.columns, out)?;
        self.changed.clear();
        Ok(())
    }
}
