//! Reads pcapng.

use super::block::{
    self, ENHANCED_PACKET, EPB_DROPCOUNT, EPB_FLAGS, FRAMING, INTERFACE_DESCRIPTION, INTERFACE_STATISTICS, ISB_IFDROP,
    ISB_OSDROP, PACKET, Packet, SECTION_HEADER, SIMPLE_PACKET,
};
use super::interface::{self, Interface};
use super::usual;
use crate::formats::socketcan::{self, LINK_TYPES};
use crate::{Channels, Damage, DamageKind, Direction, Place, ReadOptions, Reader, Record, Source, SourceError};
use crate::{TimeBase, Timestamp};
use nom::number::Endianness;
use nom::number::complete::u32;
use nom::{IResult, Parser};
use std::borrow::Cow;

/// The longest block that is looked into. Longer ones are passed over: none of them is a CAN frame.
const LONGEST: u32 = 512 * 1024;
/// How many interfaces of a section are told apart.
const MOST_INTERFACES: usize = 65_536;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head.get(..4) == Some(&SECTION_HEADER.to_le_bytes())
        && head.get(8..12).is_some_and(|magic| magic.try_into().is_ok_and(|magic| block::byte_order(magic).is_some()))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(PcapngReader::new(source))
}

struct PcapngReader {
    source: Source,
    /// The byte order of the current section; `None` before the first one.
    order: Option<Endianness>,
    /// Of the current section.
    interfaces: Vec<Interface>,
    channels: Channels,
    /// Of the block read last.
    number: u64,
    /// What comes after a damage out of the same block.
    pending: Option<Result<Record, Damage>>,
    latest: Option<Timestamp>,
    /// Whether a packet without time was seen.
    untimed: bool,
    done: bool,
}

/// What a block gives.
enum Yield {
    Nothing,
    Record(Record),
    End,
}

impl PcapngReader {
    fn new(source: Source) -> Self {
        Self {
            source,
            order: None,
            interfaces: Vec::new(),
            channels: Channels::new(),
            number: 0,
            pending: None,
            latest: None,
            untimed: false,
            done: false,
        }
    }

    fn place(&self) -> Place {
        Place { number: self.number, offset: self.source.offset() }
    }

    fn damage(&self, kind: DamageKind, expected: impl Into<Cow<'static, str>>, found: &str) -> Damage {
        Damage::new(kind, self.place(), expected, found.as_bytes())
    }

    fn source_failed(&mut self, error: &SourceError) -> Damage {
        self.done = true;
        Damage::source(error, self.place())
    }

    #[inline]
    fn has(&mut self, n: usize) -> Result<bool, Damage> {
        self.source.fill_to(n).map_err(|error| self.source_failed(&error))
    }

    /// The file ends in a block.
    fn cut(&mut self, expected: String) -> Damage {
        self.done = true;
        let found = format!("the end of the file after {}", self.source.window().len());
        self.damage(DamageKind::Truncated, expected, &found)
    }

    /// The byte order of the block at hand: a section header tells its own.
    fn order_of(&mut self, head: [u8; 12]) -> Result<Endianness, Damage> {
        let [t0, t1, t2, t3, _, _, _, _, magic @ ..] = head;
        if u32::from_le_bytes([t0, t1, t2, t3]) != SECTION_HEADER {
            return self
                .order
                .ok_or_else(|| self.damage(DamageKind::Fatal, "a section header block at the beginning", ""));
        }
        block::byte_order(magic).ok_or_else(|| {
            let found = format!("{:08X}h", u32::from_be_bytes(magic));
            self.damage(DamageKind::Fatal, "the byte order magic 1A2B3C4Dh in a section header", &found)
        })
    }

    /// The record of the next block, if it is one of those that most are.
    #[inline]
    fn usual_block(&mut self) -> Option<Record> {
        let (record, size) = usual::packet(self.order?, &self.interfaces, self.source.window())?;
        self.number += 1;
        self.latest = Some(record.timestamp);
        let record = record.at(self.number, self.source.offset());
        self.source.consume(size);
        Some(record)
    }

    fn block(&mut self) -> Result<Yield, Damage> {
        self.number += 1;
        if !self.has(FRAMING)? {
            if self.source.window().is_empty() {
                return Ok(Yield::End);
            }
            return Err(self.cut("a block of at least 12 bytes".into()));
        }
        let Some(&head) = self.source.window().first_chunk::<FRAMING>() else {
            return Ok(Yield::End);
        };
        let order = self.order_of(head)?;
        let parsed: IResult<_, _> = (u32(order), u32(order)).parse(&head[..]);
        let Ok((_, (kind, length))) = parsed else { return Ok(Yield::End) };
        if length < FRAMING as u32 {
            let found = format!("length {length}");
            return Err(self.damage(DamageKind::Fatal, "a block of at least 12 bytes", &found));
        }
        // Blocks begin at multiples of four, whatever the writer says.
        let size = u64::from(length).next_multiple_of(4);
        if length > LONGEST {
            return self.pass_over(kind, size);
        }
        if !self.has(size as usize)? {
            // The filling of the very last block may be absent.
            if self.source.window().len() < length as usize {
                return Err(self.cut(format!("a block of {length} bytes")));
            }
        }
        let result = self.whole(order, kind, length as usize);
        self.source.consume(size as usize);
        result
    }

    /// Passes over a block that is too long to be a CAN frame.
    fn pass_over(&mut self, kind: u32, size: u64) -> Result<Yield, Damage> {
        let place = self.place();
        let skipped = self.source.skip(size).map_err(|error| self.source_failed(&error))?;
        if skipped < size {
            self.done = true;
            let found = format!("the end of the file after {skipped}");
            return Err(Damage::new(
                DamageKind::Truncated,
                place,
                format!("a block of {size} bytes"),
                found.as_bytes(),
            ));
        }
        if !matches!(kind, SECTION_HEADER | INTERFACE_DESCRIPTION | PACKET | SIMPLE_PACKET | ENHANCED_PACKET) {
            return Ok(Yield::Nothing);
        }
        let expected = format!("a block of at most {LONGEST} bytes");
        Err(Damage::new(DamageKind::Malformed, place, expected, size.to_string().as_bytes()))
    }

    /// A block that is at hand as a whole.
    #[inline]
    fn whole(&mut self, order: Endianness, kind: u32, length: usize) -> Result<Yield, Damage> {
        let place = self.place();
        let window = self.source.window();
        let (Some(body), Some(trailer)) = (window.get(8..length - 4), window.get(length - 4..length)) else {
            return Ok(Yield::Nothing);
        };
        let again = block::option_u32(order, trailer);
        if again != Some(length as u32) {
            let found = format!("{}", again.unwrap_or_default());
            let expected = format!("the block's length {length} again at its end");
            return Err(Damage::new(DamageKind::Malformed, place, expected, found.as_bytes()));
        }
        let packet = match kind {
            ENHANCED_PACKET => block::enhanced_packet(order, body),
            PACKET => block::packet(order, body),
            SIMPLE_PACKET => {
                let snapshot = self.interfaces.first().map_or(0, |interface| interface.snapshot);
                block::simple_packet(order, snapshot, body)
            }
            SECTION_HEADER => return section(&mut self.order, &mut self.interfaces, order, place, body),
            INTERFACE_DESCRIPTION => {
                let described = describe(&mut self.interfaces, &mut self.channels, order, body);
                return if described { Ok(Yield::Nothing) } else { Err(unreadable(place, "an interface description")) };
            }
            INTERFACE_STATISTICS => return statistics(&mut self.interfaces, order, place, body),
            _ => return Ok(Yield::Nothing),
        };
        let Ok((_, packet)) = packet else {
            return Err(unreadable(place, "a packet that fits into its block"));
        };
        let mut frames = Frames {
            interfaces: &mut self.interfaces,
            channels: &mut self.channels,
            latest: &mut self.latest,
            untimed: &mut self.untimed,
        };
        let (damage, record) = frames.read(order, place, &packet);
        match damage {
            Some(damage) => {
                self.pending = Some(record);
                Err(damage)
            }
            None => record.map(Yield::Record),
        }
    }
}

fn unreadable(place: Place, expected: &'static str) -> Damage {
    Damage::new(DamageKind::Malformed, place, expected, b"")
}

/// A section begins: byte order and interfaces begin anew.
fn section(
    current: &mut Option<Endianness>,
    interfaces: &mut Vec<Interface>,
    order: Endianness,
    place: Place,
    body: &[u8],
) -> Result<Yield, Damage> {
    let parsed: IResult<_, _> = (u32(order), nom::number::complete::u16(order)).parse(body);
    let Ok((_, (_, major))) = parsed else {
        return Err(Damage::new(DamageKind::Fatal, place, "a section header of at least 16 bytes", b""));
    };
    if major != 1 {
        return Err(Damage::new(DamageKind::Fatal, place, "pcapng version 1", major.to_string().as_bytes()));
    }
    *current = Some(order);
    interfaces.clear();
    Ok(Yield::Nothing)
}

/// Adds an interface; whether its description could be read.
fn describe(interfaces: &mut Vec<Interface>, channels: &mut Channels, order: Endianness, body: &[u8]) -> bool {
    let number = interfaces.len();
    if number >= MOST_INTERFACES {
        return false;
    }
    match interface::description(order, number, channels, body) {
        Ok((_, (interface, readable))) => {
            interfaces.push(interface);
            readable
        }
        Err(_) => false,
    }
}

/// Interface statistics tell how many frames were lost since the beginning.
fn statistics(interfaces: &mut [Interface], order: Endianness, place: Place, body: &[u8]) -> Result<Yield, Damage> {
    let parsed: IResult<_, _> = (u32(order), u32(order), u32(order)).parse(body);
    let Ok((options, (number, _, _))) = parsed else {
        return Err(unreadable(place, "interface statistics"));
    };
    let mut dropped = 0u64;
    block::for_each_option(order, options, |code, value| {
        if matches!(code, ISB_IFDROP | ISB_OSDROP) {
            dropped = dropped.saturating_add(block::option_u64(order, value).unwrap_or_default());
        }
    });
    match interfaces.get_mut(number as usize) {
        Some(interface) if dropped > interface.dropped => {
            let more = dropped - std::mem::replace(&mut interface.dropped, dropped);
            Err(Damage::new(DamageKind::Dropped(more), place, "no lost frames", b""))
        }
        _ => Ok(Yield::Nothing),
    }
}

/// The part of the reader that makes frames of packets.
struct Frames<'a> {
    interfaces: &'a mut Vec<Interface>,
    channels: &'a mut Channels,
    latest: &'a mut Option<Timestamp>,
    untimed: &'a mut bool,
}

impl Frames<'_> {
    /// The packet's frame, and the damage that goes before it.
    #[inline]
    fn read(
        &mut self,
        order: Endianness,
        place: Place,
        packet: &Packet<'_>,
    ) -> (Option<Damage>, Result<Record, Damage>) {
        let mut record = self.frame(order, place, packet);
        if packet.options.is_empty() && packet.drops == 0 {
            return (None, record);
        }
        let (mut direction, mut drops) = (Direction::Unknown, packet.drops);
        let readable = block::for_each_option(order, packet.options, |code, value| match code {
            EPB_FLAGS => direction = block::flags_direction(block::option_u32(order, value).unwrap_or_default()),
            EPB_DROPCOUNT => drops = block::option_u64(order, value).unwrap_or_default(),
            _ => {}
        });
        if let (Ok(record), Direction::Rx | Direction::Tx) = (&mut record, direction) {
            record.direction = direction;
        }
        let damage = if drops > 0 {
            Some(self.dropped(place, packet.interface, drops))
        } else {
            (!readable).then(|| unreadable(place, "packet options that fit into their block"))
        };
        (damage, record)
    }

    fn dropped(&mut self, place: Place, interface: u32, drops: u64) -> Damage {
        if let Some(interface) = self.interfaces.get_mut(interface as usize) {
            interface.dropped = interface.dropped.saturating_add(drops);
        }
        Damage::new(DamageKind::Dropped(drops), place, "no lost frames", b"")
    }

    #[inline]
    fn frame(&mut self, order: Endianness, place: Place, packet: &Packet<'_>) -> Result<Record, Damage> {
        let damage =
            |kind, expected: Cow<'static, str>, found: &str| Damage::new(kind, place, expected, found.as_bytes());
        let Some(interface) = self.interfaces.get(packet.interface as usize) else {
            let expected = format!("one of the section's {} interfaces", self.interfaces.len());
            return Err(damage(DamageKind::Malformed, expected.into(), &packet.interface.to_string()));
        };
        let Some(link) = interface.link else {
            let found = format!("link type {}", interface.link_number);
            return Err(damage(DamageKind::Unsupported, LINK_TYPES.into(), &found));
        };
        if packet.data.len() < packet.original as usize {
            let expected = format!("a packet of {} bytes", packet.original);
            return Err(damage(DamageKind::Truncated, expected.into(), &format!("cut to {}", packet.data.len())));
        }
        let timestamp = match packet.time {
            Some(time) => *self.latest.insert(interface.clock.timestamp(time)),
            // Among packets with times one without is not earlier than those before it.
            None => {
                *self.untimed = true;
                self.latest.unwrap_or_default()
            }
        };
        let seen = socketcan::decode(link, order, packet.data).map_err(|flaw| flaw.damage(place))?;
        let mut record = seen.record;
        record.channel = match seen.interface {
            Some(index) => self.channels.intern(&format!("if{index}")),
            None => interface.channel,
        };
        (record.timestamp, record.place) = (timestamp, place);
        Ok(record)
    }
}

impl Iterator for PcapngReader {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(pending) = self.pending.take() {
            return Some(pending);
        }
        while !self.done {
            if let Some(record) = self.usual_block() {
                return Some(Ok(record));
            }
            match self.block() {
                Ok(Yield::Record(record)) => return Some(Ok(record)),
                Ok(Yield::Nothing) => {}
                Ok(Yield::End) => self.done = true,
                Err(damage) => {
                    self.done |= damage.kind.is_fatal();
                    return Some(Err(damage));
                }
            }
        }
        None
    }
}

impl Reader for PcapngReader {
    fn channels(&self) -> &Channels {
        &self.channels
    }

    fn time_base(&self) -> TimeBase {
        if self.untimed && self.latest.is_none() { TimeBase::None } else { TimeBase::Utc }
    }
}

#[cfg(test)]
mod tests;
