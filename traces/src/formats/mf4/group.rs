//! Groups of records, and the channels that make frames of them.

use super::block::{Block, chain};
use super::channel::{Channel, channels};
use super::data::content;
use crate::damage::Flaw;
use crate::formats::asc::LATEST;
use crate::formats::blf::{bus_error, classical, fd};
use crate::{CanId, ChannelId, Direction, Record, Timestamp};
use nom::bytes::complete::take;
use nom::number::complete::{le_u16, le_u32, le_u64};
use nom::{IResult, Parser};
use std::borrow::Cow;
use std::collections::BTreeMap;

/// The records of one kind in a data group.
#[derive(Debug)]
pub(super) struct Group<'a> {
    /// The number with which each record begins, if the data group has several groups.
    pub id: u64,
    /// Whether the records are values of variable length.
    pub is_of_values: bool,
    /// The length of a record, without the number of the group.
    pub length: usize,
    /// Number of records as the file says.
    pub count: u64,
    /// How a record becomes a frame; `None` for other records.
    pub frames: Option<Frames<'a>>,
}

/// The kinds of records on a CAN bus.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Kind {
    Data,
    Remote,
    Error,
}

/// The channels of a group of frames.
#[derive(Debug)]
pub(super) struct Frames<'a> {
    kind: Kind,
    time: Channel,
    /// The channels of the fields of a frame, by their names after the point: `ID`, `DataBytes`.
    members: BTreeMap<String, Channel>,
    /// The values of variable length, which are not in the records.
    values: Values<'a>,
}

/// The values of variable length of a group.
#[derive(Debug)]
enum Values<'a> {
    /// The values follow each other, each with its length.
    Here(Cow<'a, [u8]>),
    /// The values are the records of another group of the data group, the block of which has this offset.
    InGroup(u64),
}

/// Flag of a group: its records are values of variable length.
const OF_VALUES: u16 = 0x0001;
/// Flag of a group: its records are frames or events of a bus.
const OF_BUS: u16 = 0x0002;
/// The beginnings of channels' names in groups of other buses, and of events without a frame.
const OTHER_BUSES: [&str; 7] = ["LIN_", "FLX_", "MOST_", "ETH_", "K_", "CAN_OverloadFrame", "CAN_Statistics"];

struct Head {
    id: u64,
    count: u64,
    flags: u16,
    /// Length of a record, and of its invalidation bits.
    lengths: [u32; 2],
}

/// Parses number, number of records, flags, separator, length of the record, length of its invalidation bits.
fn head(i: &[u8]) -> IResult<&[u8], Head> {
    (le_u64, le_u64, le_u16, le_u16, take(4usize), le_u32, le_u32)
        .map(|(id, count, flags, _, _, length, invalidation)| Head {
            id,
            count,
            flags,
            lengths: [length, invalidation],
        })
        .parse(i)
}

/// The groups of a data group by the offsets of their blocks.
pub(super) fn groups<'a>(file: &'a [u8], data_group: &Block<'a>) -> Result<Vec<(u64, Group<'a>)>, Flaw> {
    chain(file, data_group.link(1), b"CG").map(|block| block.and_then(|block| group(file, &block))).collect()
}

fn group<'a>(file: &'a [u8], block: &Block<'a>) -> Result<(u64, Group<'a>), Flaw> {
    let Ok((_, Head { id, count, flags, lengths })) = head(block.data) else {
        return Err(Flaw::malformed("a whole channel group", format!("{} bytes", block.data.len())));
    };
    let is_of_values = flags & OF_VALUES != 0;
    if is_of_values && block.link(1).is_some() {
        return Err(Flaw::malformed("a group of values, which has no channels", "one with channels"));
    }
    let length = lengths.iter().map(|length| *length as usize).sum();
    let frames = match is_of_values {
        true => None,
        false => frames(file, known(channels(file, block.link(1))?, flags, length)?),
    };
    Ok((block.offset, Group { id, is_of_values, length, count, frames }))
}

/// The channels of a group, if they fit into its records, and are of a bus that is known.
fn known(channels: Vec<Channel>, flags: u16, length: usize) -> Result<Vec<Channel>, Flaw> {
    if let Some(beyond) = channels.iter().find(|channel| !channel.fits(length)) {
        let found = format!("{} beyond {length} bytes", beyond.name);
        return Err(Flaw::malformed("channels within the record, whose length the group says", found));
    }
    let is_of_other = |name: &str| OTHER_BUSES.iter().any(|other| name.starts_with(other));
    let is_known = |channel: &Channel| kind_of(&channel.name).is_some() || is_of_other(&channel.name);
    let has_time = channels.iter().any(Channel::is_master);
    if flags & OF_BUS == 0 || has_time && channels.iter().any(is_known) {
        return Ok(channels);
    }
    let named = channels.iter().map(|channel| channel.name.as_str()).find(|name| name.contains('.'));
    let found = named.unwrap_or("channels without time or name").to_owned();
    Err(Flaw::malformed("frames of a known bus with their time, as the group says", found))
}

/// The kind of frames to which a channel with this name belongs.
fn kind_of(name: &str) -> Option<Kind> {
    match name.split('.').next() {
        Some("CAN_DataFrame") => Some(Kind::Data),
        Some("CAN_RemoteFrame") => Some(Kind::Remote),
        Some("CAN_ErrorFrame") => Some(Kind::Error),
        _ => None,
    }
}

/// The channels of frames among all channels of a group; `None` if the records are no frames, or have no time.
fn frames(file: &[u8], channels: Vec<Channel>) -> Option<Frames<'_>> {
    let kind = channels.iter().find_map(|channel| kind_of(&channel.name))?;
    let time = channels.iter().find(|channel| channel.is_master())?.clone();
    let of_frame = channels.into_iter().filter(|channel| kind_of(&channel.name) == Some(kind));
    let named = |channel: Channel| Some((channel.name.split_once('.')?.1.to_owned(), channel));
    let members: BTreeMap<String, Channel> = of_frame.filter_map(named).collect();
    let outside = members.get(DATA_BYTES).filter(|channel| channel.has_variable_length()).and_then(|data| data.values);
    let values = match outside.map(|offset| (offset, Block::read(file, offset))) {
        Some((offset, Ok(block))) if block.id == *b"CG" => Values::InGroup(offset),
        _ => Values::Here(content(file, outside).bytes),
    };
    Some(Frames { kind, time, members, values })
}

const DATA_BYTES: &str = "DataBytes";

impl Frames<'_> {
    /// The time of a record that counts from `start`.
    fn time(&self, record: &[u8], start: Timestamp) -> Result<Timestamp, Flaw> {
        let since = self.time.nanoseconds(record);
        let time = since.and_then(|since| start.nanos().checked_add_signed(since)).map(Timestamp);
        time.ok_or_else(|| Flaw::malformed(LATEST, format!("{since:?} ns after the start")))
    }

    fn number(&self, name: &str, record: &[u8]) -> Option<u64> {
        self.members.get(name)?.number(record)
    }

    fn flag(&self, name: &str, record: &[u8]) -> bool {
        self.number(name, record).is_some_and(|value| value != 0)
    }

    /// The number of the bus; 1 if the records do not tell.
    pub fn bus(&self, record: &[u8]) -> u64 {
        self.number("BusChannel", record).unwrap_or(1)
    }

    /// The frame of a record, with time and direction. `start`: the start of the measurement. `values`: the values of
    /// variable length of each group.
    pub fn record(&self, record: &[u8], start: Timestamp, values: &BTreeMap<u64, Vec<u8>>) -> Result<Record, Flaw> {
        let time = self.time(record, start)?;
        let direction = match self.number("Dir", record) {
            Some(0) => Direction::Rx,
            Some(1) => Direction::Tx,
            _ => Direction::Unknown,
        };
        let made = match self.kind {
            Kind::Error => Record::new(time, ChannelId::default(), bus_error()),
            Kind::Remote => {
                let frame = classical(self.identifier(record)?, true, self.dlc(record)?, &[])?;
                Record::new(time, ChannelId::default(), frame)
            }
            Kind::Data => self.data_frame(record, values, time)?,
        };
        Ok(made.with_direction(direction))
    }

    fn data_frame(&self, record: &[u8], values: &BTreeMap<u64, Vec<u8>>, time: Timestamp) -> Result<Record, Flaw> {
        let id = self.identifier(record)?;
        let stored = self.data(record, values)?;
        let length = self.number("DataLength", record).map_or(stored.len(), |length| length as usize);
        let data = stored.get(..length);
        let data = data.ok_or_else(|| Flaw::malformed(format!("{length} bytes of data"), stored.len().to_string()))?;
        if self.flag("EDL", record) {
            let flags = fd(self.flag("BRS", record), self.flag("ESI", record));
            let made = Record::fd(time, ChannelId::default(), id, flags, data);
            return made.ok_or_else(|| Flaw::malformed("a length that CAN FD has", length.to_string()));
        }
        let dlc = self.number("DLC", record).map_or(Ok(length as u8), |_| self.dlc(record))?;
        Ok(Record::new(time, ChannelId::default(), classical(id, false, dlc, data)?))
    }

    fn identifier(&self, record: &[u8]) -> Result<CanId, Flaw> {
        /// Bit that some recorders set in an identifier of 29 bits.
        const EXTENDED: u64 = 1 << 31;
        let number = self.number("ID", record).ok_or_else(|| Flaw::malformed("a record with an identifier", "none"))?;
        let (raw, is_marked) = (number & !EXTENDED, number & EXTENDED != 0);
        let is_extended = is_marked || self.flag("IDE", record) || raw > u64::from(CanId::MAX_STANDARD);
        let raw = u32::try_from(raw).unwrap_or(u32::MAX);
        let id = if is_extended { CanId::extended(raw) } else { CanId::standard(raw) };
        id.ok_or_else(|| Flaw::malformed("an identifier of at most 29 bits", format!("{number:X}h")))
    }

    fn dlc(&self, record: &[u8]) -> Result<u8, Flaw> {
        let dlc = self.number("DLC", record).or_else(|| self.number("DataLength", record)).unwrap_or_default();
        u8::try_from(dlc).map_err(|_| Flaw::malformed("a data length code of at most 15", dlc.to_string()))
    }

    /// The data bytes that are stored, of which the frame may have fewer.
    fn data<'b>(&'b self, record: &'b [u8], values: &'b BTreeMap<u64, Vec<u8>>) -> Result<&'b [u8], Flaw> {
        let missing = || Flaw::malformed("a record with data bytes", "none");
        let channel = self.members.get(DATA_BYTES).ok_or_else(missing)?;
        if !channel.has_variable_length() {
            return channel.bytes(record).ok_or_else(missing);
        }
        let all = match &self.values {
            Values::Here(bytes) => bytes,
            Values::InGroup(offset) => values.get(offset).map(Vec::as_slice).unwrap_or_default(),
        };
        let at = channel.number(record).ok_or_else(missing)?;
        let value = usize::try_from(at).ok().and_then(|at| all.get(at..)).and_then(|rest| value(rest).ok());
        value.map(|(_, value)| value).ok_or_else(|| Flaw::malformed("a place among the values", at.to_string()))
    }
}

/// Parses a value of variable length: its length and its bytes.
pub(super) fn value(i: &[u8]) -> IResult<&[u8], &[u8]> {
    let (i, length) = le_u32.parse(i)?;
    take(length as usize).parse(i)
}
