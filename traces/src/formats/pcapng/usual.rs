//! The quick way for packets as most are: the same as the reader's long way gives, which takes all others.

use super::block::{self, ENHANCED_PACKET, EPB_FLAGS};
use super::interface::Interface;
use crate::formats::socketcan::{self, LinkType};
use crate::{Direction, Record};
use nom::number::Endianness;

/// Type, length, interface, time (upper and lower half), captured and original length.
const HEADER: usize = 28;

/// The record of the block that the window begins with and the block's size, if the window holds all of it and it is an
/// enhanced packet with a classical data frame and no option but the direction.
#[inline]
pub(crate) fn packet(order: Endianness, interfaces: &[Interface], window: &[u8]) -> Option<(Record, usize)> {
    let (header, rest) = window.split_first_chunk::<HEADER>()?;
    let &[kind, length, interface, high, low, captured, original] = header.as_chunks().0 else { return None };
    let word = |bytes| block::word(order, bytes);
    let (size, captured) = (word(length) as usize, word(captured) as usize);
    let interface = interfaces.get(word(interface) as usize)?;
    let socketcan = interface.link == Some(LinkType::SocketCan);
    if word(kind) != ENHANCED_PACKET || captured != word(original) as usize || size % 4 != 0 || !socketcan {
        return None;
    }
    let (body, trailer) = rest.get(..size.checked_sub(HEADER)?)?.split_last_chunk::<4>()?;
    let options = body.get(captured.checked_next_multiple_of(4)?..)?;
    if *trailer != length {
        return None;
    }
    let frame = socketcan::common_frame(body.get(..captured)?)?;
    let timestamp = interface.clock.timestamp(u64::from(word(high)) << 32 | u64::from(word(low)));
    let mut record = Record::new(timestamp, interface.channel, frame);
    record.direction = direction(order, options)?;
    Some((record, size))
}

/// The direction in a packet's options, if they hold nothing else.
#[inline]
fn direction(order: Endianness, options: &[u8]) -> Option<Direction> {
    match options {
        [] => Some(Direction::Unknown),
        &[c0, c1, l0, l1, f0, f1, f2, f3, 0, 0, 0, 0] => {
            let [code, length] = match order {
                Endianness::Big => [[c0, c1], [l0, l1]].map(u16::from_be_bytes),
                _ => [[c0, c1], [l0, l1]].map(u16::from_le_bytes),
            };
            (code == EPB_FLAGS && length == 4).then(|| block::flags_direction(block::word(order, [f0, f1, f2, f3])))
        }
        _ => None,
    }
}
