//! Writes MF4 as ASAM MDF bus logging has it: a group each for classical frames, CAN FD frames, remote frames and error
//! frames, whose records follow each other in the order in which they come.
//!
//! All blocks but that of the records are at the beginning of the file. The counts of records and the length of their
//! block are known at the end. Until then the file says that it is not finished, and readers count for themselves.

use super::layout::Layout;
use crate::channel_numbers::ChannelNumbers;
use crate::{Channels, Direction, Flags, Loss, Losses, Record, TimeBase, WriteError, WriteOptions, Writer};
use std::io::Write;

/// The groups of records, by their numbers.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Classical,
    Fd,
    Remote,
    Error,
}

impl Kind {
    pub const ALL: [Self; 4] = [Self::Classical, Self::Fd, Self::Remote, Self::Error];

    /// The name of the channel that holds the frame.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Classical | Self::Fd => "CAN_DataFrame",
            Self::Remote => "CAN_RemoteFrame",
            Self::Error => "CAN_ErrorFrame",
        }
    }

    /// Number of data bytes in a record.
    pub const fn data(self) -> u32 {
        match self {
            Self::Classical => 8,
            Self::Fd => 64,
            Self::Remote | Self::Error => 0,
        }
    }
}

/// A field of a frame: its name, its place in the record behind the time, and its number of bits.
pub(super) struct Field {
    pub name: &'static str,
    pub byte: u32,
    pub bit: u8,
    pub bits: u32,
}

const fn field(name: &'static str, byte: u32, bit: u8, bits: u32) -> Field {
    Field { name, byte, bit, bits }
}

/// The fields that every record has. The bits of byte 6: IDE, EDL, BRS, ESI, direction.
pub(super) const FIELDS: [Field; 9] = [
    field("BusChannel", 0, 0, 16),
    field("ID", 2, 0, 29),
    field("IDE", 6, 0, 1),
    field("EDL", 6, 1, 1),
    field("BRS", 6, 2, 1),
    field("ESI", 6, 3, 1),
    field("Dir", 6, 4, 1),
    field("DLC", 7, 0, 4),
    field("DataLength", 8, 0, 7),
];
/// The place of the data bytes behind the time, and so the length of all fields before them.
pub(super) const DATA_AT: u32 = 9;
/// Length of a time in a record.
pub(super) const TIME: u32 = 8;

struct Mf4Writer {
    sink: Box<dyn Write>,
    /// Whether the blocks before the records were written: they have the time of the first record, also if the file is
    /// never finished.
    is_begun: bool,
    time_base: TimeBase,
    /// Start of the measurement; `None` before the first record.
    start: Option<u64>,
    /// Number of records of each group.
    counts: [u64; 4],
    /// Length of all records.
    length: u64,
    /// The record being written.
    row: Vec<u8>,
    numbers: ChannelNumbers,
    losses: Losses,
    /// The blocks before the records, when the file is finished.
    beginning: Option<Vec<u8>>,
}

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    Ok(Box::new(Mf4Writer {
        sink,
        is_begun: false,
        time_base: options.time_base,
        start: None,
        counts: [0; 4],
        length: 0,
        row: Vec::new(),
        numbers: ChannelNumbers::default(),
        losses: Losses::default(),
        beginning: None,
    }))
}

impl Mf4Writer {
    /// The blocks before the records.
    fn layout(&self, is_finished: bool) -> Vec<u8> {
        let start = self.start.unwrap_or_default();
        let is_local = self.time_base == TimeBase::Local;
        match is_finished {
            true => Layout::finished(start, is_local, self.length, self.counts),
            false => Layout::unfinished(start, is_local),
        }
        .bytes()
    }

    /// Writes the blocks before the records, of a file that is not finished.
    fn begin(&mut self) -> Result<(), WriteError> {
        if !std::mem::replace(&mut self.is_begun, true) {
            self.sink.write_all(&self.layout(false))?;
        }
        Ok(())
    }

    /// Encodes a record: number of the group, time, fields, data.
    fn encode(&mut self, record: &Record, kind: Kind, channel: u16) {
        let frame = &record.frame;
        let since = record.timestamp.nanos().saturating_sub(self.start.unwrap_or_default());
        let flag = |set: bool, bit: u8| u8::from(set) << bit;
        let flags = flag(frame.id().is_extended() && kind != Kind::Error, 0)
            | flag(frame.is_fd(), 1)
            | flag(frame.flags().contains(Flags::BRS), 2)
            | flag(frame.flags().contains(Flags::ESI), 3)
            | flag(record.direction == Direction::Tx, 4);
        let id = if kind == Kind::Error { 0 } else { frame.id().raw() };
        let data = if kind.data() > 0 { record.data() } else { &[] };
        self.row.clear();
        self.row.push(kind as u8);
        self.row.extend(since.to_le_bytes());
        self.row.extend(channel.to_le_bytes());
        self.row.extend(id.to_le_bytes());
        self.row.extend([flags, if kind == Kind::Error { 0 } else { frame.dlc() }, data.len() as u8]);
        let end = self.row.len() + kind.data() as usize;
        self.row.extend_from_slice(data);
        self.row.resize(end, 0);
    }

    fn count_losses(&mut self, record: &Record) {
        let losses = &mut self.losses;
        losses.count_any(Loss::of_utc(self.time_base).filter(|loss| *loss == Loss::UnknownDate));
        if record.timestamp.nanos() < self.start.unwrap_or_default() {
            losses.count(Loss::TimeResolution);
        }
        if record.direction == Direction::Unknown {
            losses.count(Loss::Direction);
        }
        if record.frame.error_class().is_some_and(|class| class.0 != 0x80)
            || record.frame.is_error() && !record.frame.is_empty()
        {
            losses.count(Loss::ErrorDetail);
        }
        if record.comment().is_some() {
            losses.count(Loss::Comment);
        }
    }
}

const fn kind(record: &Record) -> Kind {
    match () {
        () if record.frame.is_error() => Kind::Error,
        () if record.frame.is_remote() => Kind::Remote,
        () if record.frame.is_fd() => Kind::Fd,
        () => Kind::Classical,
    }
}

impl Writer for Mf4Writer {
    fn write(&mut self, record: &Record, channels: &Channels) -> Result<(), WriteError> {
        if record.frame.is_xl() {
            self.losses.count(Loss::Frame);
            return Ok(());
        }
        let channel = self.numbers.number(record.channel, channels.name(record.channel), &mut self.losses);
        self.start.get_or_insert(record.timestamp.nanos());
        self.begin()?;
        self.count_losses(record);
        let kind = kind(record);
        self.encode(record, kind, channel);
        self.counts[kind as usize] += 1;
        self.length += self.row.len() as u64;
        Ok(self.sink.write_all(&self.row)?)
    }

    fn flush(&mut self) -> Result<(), WriteError> {
        Ok(self.sink.flush()?)
    }

    fn finish(&mut self) -> Result<(), WriteError> {
        self.begin()?;
        self.sink.flush()?;
        self.beginning = Some(self.layout(true));
        Ok(())
    }

    fn losses(&self) -> &Losses {
        &self.losses
    }

    fn beginning(&self) -> Option<&[u8]> {
        self.beginning.as_deref()
    }
}
