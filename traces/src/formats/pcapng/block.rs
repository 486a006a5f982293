//! The blocks of pcapng, as far as they are read: their types, fields and options.

use crate::Direction;
use nom::bytes::complete::take;
use nom::number::Endianness;
use nom::number::complete::{u16, u32};
use nom::{IResult, Parser};

/// Reads the same in both byte orders.
pub(crate) const SECTION_HEADER: u32 = 0x0A0D_0D0A;
pub(crate) const INTERFACE_DESCRIPTION: u32 = 1;
/// The obsolete packet block.
pub(crate) const PACKET: u32 = 2;
pub(crate) const SIMPLE_PACKET: u32 = 3;
pub(crate) const INTERFACE_STATISTICS: u32 = 5;
pub(crate) const ENHANCED_PACKET: u32 = 6;
/// In a section header: tells the byte order.
pub(crate) const BYTE_ORDER_MAGIC: u32 = 0x1A2B_3C4D;
/// Type and length before the body, length after it.
pub(crate) const FRAMING: usize = 12;

/// Option codes.
pub(crate) const IF_NAME: u16 = 2;
pub(crate) const IF_TSRESOL: u16 = 9;
pub(crate) const IF_TSOFFSET: u16 = 14;
pub(crate) const EPB_FLAGS: u16 = 2;
pub(crate) const EPB_DROPCOUNT: u16 = 4;
pub(crate) const ISB_IFDROP: u16 = 5;
pub(crate) const ISB_OSDROP: u16 = 7;
pub(crate) const SHB_USERAPPL: u16 = 4;

/// A packet of any of the three kinds of blocks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Packet<'a> {
    pub(crate) interface: u32,
    /// In the interface's units; `None` for a simple packet block.
    pub(crate) time: Option<u64>,
    pub(crate) original: u32,
    pub(crate) data: &'a [u8],
    pub(crate) options: &'a [u8],
    /// Frames lost before this one, from the obsolete packet block.
    pub(crate) drops: u64,
}

/// The byte order of a section, from its header block's magic number.
pub(crate) fn byte_order(magic: [u8; 4]) -> Option<Endianness> {
    match u32::from_le_bytes(magic) {
        BYTE_ORDER_MAGIC => Some(Endianness::Little),
        swapped if swapped.swap_bytes() == BYTE_ORDER_MAGIC => Some(Endianness::Big),
        _ => None,
    }
}

/// Bytes filled up to a multiple of four; the filling of the last ones may be absent.
#[inline]
fn padded(len: usize, i: &[u8]) -> IResult<&[u8], &[u8]> {
    let (rest, data) = take(len).parse(i)?;
    let filling = (4 - len % 4) % 4;
    Ok((rest.get(filling..).unwrap_or_default(), data))
}

/// The body of an enhanced packet block.
#[inline]
pub(crate) fn enhanced_packet(order: Endianness, i: &[u8]) -> IResult<&[u8], Packet<'_>> {
    let (i, (interface, high, low, captured, original)) =
        (u32(order), u32(order), u32(order), u32(order), u32(order)).parse(i)?;
    let (options, data) = padded(captured as usize, i)?;
    let time = Some(u64::from(high) << 32 | u64::from(low));
    Ok((&[], Packet { interface, time, original, data, options, drops: 0 }))
}

/// The body of an obsolete packet block.
pub(crate) fn packet(order: Endianness, i: &[u8]) -> IResult<&[u8], Packet<'_>> {
    let (i, (interface, drops, high, low, captured, original)) =
        (u16(order), u16(order), u32(order), u32(order), u32(order), u32(order)).parse(i)?;
    let (options, data) = padded(captured as usize, i)?;
    let time = Some(u64::from(high) << 32 | u64::from(low));
    // FFFFh: not known.
    let drops = if drops == u16::MAX { 0 } else { u64::from(drops) };
    Ok((&[], Packet { interface: interface.into(), time, original, data, options, drops }))
}

/// The body of a simple packet block: cut to the snapshot length of the section's first interface, 0 for none.
pub(crate) fn simple_packet(order: Endianness, snapshot: u32, i: &[u8]) -> IResult<&[u8], Packet<'_>> {
    let (i, original) = u32(order).parse(i)?;
    let captured = if snapshot == 0 { original } else { original.min(snapshot) };
    let (_, data) = take(captured as usize).parse(i)?;
    Ok((&[], Packet { interface: 0, time: None, original, data, options: &[], drops: 0 }))
}

/// An option's code and value.
pub(crate) type BlockOption<'a> = (u16, &'a [u8]);

/// The next option; `None` at the end of the options.
pub(crate) fn option(order: Endianness, i: &[u8]) -> IResult<&[u8], Option<BlockOption<'_>>> {
    if i.is_empty() {
        return Ok((i, None));
    }
    let (i, (code, len)) = (u16(order), u16(order)).parse(i)?;
    if code == 0 {
        return Ok((&[], None));
    }
    let (i, value) = padded(usize::from(len), i)?;
    Ok((i, Some((code, value))))
}

/// Hands each option to `each`; whether all of them could be read.
pub(crate) fn for_each_option<'a>(order: Endianness, mut i: &'a [u8], mut each: impl FnMut(u16, &'a [u8])) -> bool {
    loop {
        match option(order, i) {
            Ok((rest, Some((code, value)))) => {
                each(code, value);
                i = rest;
            }
            Ok((_, None)) => return true,
            Err(_) => return false,
        }
    }
}

/// The direction of a packet, bits 0 and 1 of [`EPB_FLAGS`]: 1 inbound, 2 outbound.
pub(crate) const fn flags_direction(flags: u32) -> Direction {
    match flags & 3 {
        1 => Direction::Rx,
        2 => Direction::Tx,
        _ => Direction::Unknown,
    }
}

/// A number of four bytes.
#[inline]
pub(crate) fn word(order: Endianness, bytes: [u8; 4]) -> u32 {
    if matches!(order, Endianness::Big) { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) }
}

/// The value of an option of four bytes.
pub(crate) fn option_u32(order: Endianness, value: &[u8]) -> Option<u32> {
    value.try_into().ok().map(|bytes| word(order, bytes))
}

/// The value of an option of eight bytes.
pub(crate) fn option_u64(order: Endianness, value: &[u8]) -> Option<u64> {
    let bytes = value.try_into().ok()?;
    Some(if matches!(order, Endianness::Big) { u64::from_be_bytes(bytes) } else { u64::from_le_bytes(bytes) })
}
