//! A record in few bytes, encoded as the difference from the previous record.
//!
//! ```text
//! head: 0 usual (11 bits, classical data, no DLC above 8), 1 same channel, 2 number is one more, 4..5 direction, 6 CAN XL
//! time since the record before (zigzag varint, ns)
//! channel (varint), if it is another channel; difference of the number (zigzag varint), if it is not 1
//! usual:  CAN-ID and length (16 bits: 0..10 CAN-ID, 11..14 length), data
//! XL:     priority, vcid, flags, sdt, af, length (varints), data
//! other:  length (varint), the frame as a socket takes it
//! ```
//!
//! Comments and offsets are left out.

use canvass_traces::{CanId, ChannelId, Direction, Frame, Place, Record, Timestamp, XlHeader, from_socket, to_socket};

const USUAL: u8 = 1;
const SAME_CHANNEL: u8 = 2;
const NEXT_NUMBER: u8 = 4;
const DIRECTION: u8 = 0x30;
const XL: u8 = 0x40;

/// The values of the previous record, from which the next record is encoded as differences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Before {
    time: u64,
    channel: u16,
    number: u64,
}

impl Before {
    const fn of(record: &Record) -> Self {
        Self { time: record.timestamp.nanos(), channel: record.channel.0, number: record.place.number }
    }
}

/// Appends a record.
pub fn push(record: &Record, before: &mut Before, out: &mut Vec<u8>) {
    let now = Before::of(record);
    let usual = is_usual(record);
    let direction = match record.direction {
        Direction::Unknown => 0,
        Direction::Rx => 1,
        Direction::Tx => 2,
    };
    let xl = record.xl_header();
    let (same, next) = (now.channel == before.channel, now.number == before.number.wrapping_add(1));
    let flag = |set: bool, flag: u8| if set { flag } else { 0 };
    let mut begin = Begin::EMPTY;
    begin.push(
        flag(usual, USUAL)
            | flag(same, SAME_CHANNEL)
            | flag(next, NEXT_NUMBER)
            | direction << 4
            | flag(xl.is_some(), XL),
    );
    begin.push_signed(now.time.wrapping_sub(before.time).cast_signed());
    if !same {
        begin.push_number(u64::from(now.channel));
    }
    if !next {
        begin.push_signed(now.number.wrapping_sub(before.number).cast_signed());
    }
    *before = now;
    let data = record.data();
    if usual {
        let head = record.frame.id().raw() as u16 | (data.len() as u16) << 11;
        head.to_le_bytes().iter().for_each(|byte| begin.push(*byte));
        // The padding of the data is written too, and cut off again.
        record.frame.bytes().iter().for_each(|byte| begin.push(*byte));
        begin.len -= 8 - data.len().min(8);
    }
    out.extend_from_slice(begin.written());
    if usual {
        return;
    }
    match xl {
        Some(xl) => push_xl(record.frame.id(), xl, data, out),
        None => {
            let mut packet = Vec::new();
            to_socket(record, &mut packet);
            push_number(out, packet.len() as u64);
            out.extend_from_slice(&packet);
        }
    }
}

fn is_usual(record: &Record) -> bool {
    let frame = &record.frame;
    let plain = !frame.is_remote() && !frame.is_error() && frame.flags().bits() == 0;
    plain && !frame.id().is_extended() && frame.len() <= 8 && usize::from(frame.dlc()) == frame.len()
}

fn push_xl(priority: CanId, xl: XlHeader, data: &[u8], out: &mut Vec<u8>) {
    let flags = u64::from(xl.sec) | u64::from(xl.rrs) << 1;
    let numbers = [priority.raw().into(), xl.vcid.into(), flags, xl.sdt.into(), xl.af.into(), data.len() as u64];
    numbers.iter().for_each(|&number| push_number(out, number));
    out.extend_from_slice(data);
}

/// Takes the next record from the front of `bytes`; `None` at the end of `bytes`.
pub fn take(bytes: &mut &[u8], before: &mut Before) -> Option<Record> {
    let head = *bytes.split_off_first()?;
    let time = before.time.wrapping_add(take_signed(bytes)?.cast_unsigned());
    let channel = if head & SAME_CHANNEL != 0 { before.channel } else { take_number(bytes)? as u16 };
    let step = if head & NEXT_NUMBER != 0 { 1 } else { take_signed(bytes)? };
    let number = before.number.wrapping_add(step.cast_unsigned());
    *before = Before { time, channel, number };
    let direction = match (head & DIRECTION) >> 4 {
        1 => Direction::Rx,
        2 => Direction::Tx,
        _ => Direction::Unknown,
    };
    let mut record = match head {
        _ if head & USUAL != 0 => take_usual(bytes)?,
        _ if head & XL != 0 => take_xl(bytes)?,
        _ => {
            let length = usize::try_from(take_number(bytes)?).ok()?;
            from_socket(bytes.split_off(..length)?).ok()?
        }
    };
    record.timestamp = Timestamp(time);
    record.channel = ChannelId(channel);
    record.direction = direction;
    record.place = Place { number, offset: 0 };
    Some(record)
}

#[inline]
fn take_usual(bytes: &mut &[u8]) -> Option<Record> {
    let head = u16::from_le_bytes(bytes.split_off(..2)?.try_into().ok()?);
    let data = bytes.split_off(..usize::from(head >> 11))?;
    let frame = Frame::new(CanId::standard_masked(u32::from(head)), data)?;
    Some(Record::new(Timestamp::ZERO, ChannelId(0), frame))
}

fn take_xl(bytes: &mut &[u8]) -> Option<Record> {
    let mut next = || take_number(bytes);
    let (priority, vcid, flags) = (next()? as u32, next()? as u8, next()?);
    let xl = XlHeader { vcid, sec: flags & 1 != 0, rrs: flags & 2 != 0, sdt: next()? as u8, af: next()? as u32 };
    let length = usize::try_from(next()?).ok()?;
    let data = bytes.split_off(..length)?;
    Record::xl(Timestamp::ZERO, ChannelId(0), CanId::standard_masked(priority), xl, data)
}

fn push_number(out: &mut Vec<u8>, number: u64) {
    let mut begin = Begin::EMPTY;
    begin.push_number(number);
    out.extend_from_slice(begin.written());
}

/// The beginning of a record, or a whole usual record, which is appended in one piece.
struct Begin {
    bytes: [u8; Self::LONGEST],
    len: usize,
}

impl Begin {
    const EMPTY: Self = Self { bytes: [0; Self::LONGEST], len: 0 };
    /// Maximum length of head, time, channel, number, CAN-ID with length, and data.
    const LONGEST: usize = 1 + 10 + 3 + 10 + 2 + 8;

    #[inline(always)]
    fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(self.len) {
            *place = byte;
        }
        self.len += 1;
    }

    #[inline(always)]
    fn push_number(&mut self, mut number: u64) {
        while number >= 0x80 {
            self.push(number as u8 | 0x80);
            number >>= 7;
        }
        self.push(number as u8);
    }

    #[inline(always)]
    fn push_signed(&mut self, number: i64) {
        self.push_number(((number << 1) ^ (number >> 63)).cast_unsigned());
    }

    #[inline(always)]
    fn written(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

#[inline]
fn take_number(bytes: &mut &[u8]) -> Option<u64> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let byte = *bytes.split_off_first()?;
        number |= u64::from(byte & 0x7F) << shift;
        if byte & 0x80 == 0 {
            return Some(number);
        }
    }
    None
}

#[inline]
fn take_signed(bytes: &mut &[u8]) -> Option<i64> {
    take_number(bytes).map(|number| (number >> 1).cast_signed() ^ -(number & 1).cast_signed())
}

#[cfg(test)]
mod tests;
