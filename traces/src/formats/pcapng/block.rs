//! The blocks of pcapng: their types, their plausibility, and the content that the crate reads.

use crate::Direction;
use byteorder::{BigEndian, LittleEndian};
use pcap_file::Endianness;
use pcap_file::pcapng::blocks::{
    CUSTOM_BLOCK_COPIABLE, CUSTOM_BLOCK_NON_COPIABLE, ENHANCED_PACKET_BLOCK, INTERFACE_DESCRIPTION_BLOCK,
    INTERFACE_STATISTIC_BLOCK, NAME_RESOLUTION_BLOCK, PACKET_BLOCK, SECTION_HEADER_BLOCK, SIMPLE_PACKET_BLOCK,
    SYSTEMD_JOURNAL_EXPORT_BLOCK,
};
use pcap_file::pcapng::{BlockContentParseError, PcapNgBlock, PcapNgState, RawBlock, RawBlockParseError};

/// Total length of a block's type and of its length before and after the body.
pub(crate) const FRAMING: usize = 12;
/// Maximum length of a parsed block.
pub(crate) const LONGEST: usize = 512 * 1024;
/// The type of a block with keys of other protocols, which the crate does not know.
const DECRYPTION_SECRETS: u32 = 0x0A;

/// A block's type, and the length before its body.
#[derive(Clone, Copy)]
pub(crate) struct Head {
    pub(crate) kind: u32,
    pub(crate) length: u32,
}

impl Head {
    /// Whether blocks of this type hold no frame, and so may have any length.
    pub(crate) const fn is_aside(self) -> bool {
        matches!(
            self.kind,
            NAME_RESOLUTION_BLOCK
                | SYSTEMD_JOURNAL_EXPORT_BLOCK
                | DECRYPTION_SECRETS
                | CUSTOM_BLOCK_COPIABLE
                | CUSTOM_BLOCK_NON_COPIABLE
        )
    }

    const fn is_known(self) -> bool {
        self.is_aside()
            || matches!(
                self.kind,
                SECTION_HEADER_BLOCK
                    | INTERFACE_DESCRIPTION_BLOCK
                    | PACKET_BLOCK
                    | SIMPLE_PACKET_BLOCK
                    | INTERFACE_STATISTIC_BLOCK
                    | ENHANCED_PACKET_BLOCK
            )
    }

    /// Whether type and length are those of a possible block.
    pub(crate) const fn is_likely(self) -> bool {
        let length = self.length as usize;
        self.is_known() && length >= FRAMING && length <= LONGEST && length.is_multiple_of(4)
    }
}

/// Reads a number of four bytes.
#[inline]
pub(crate) fn word(order: Endianness, bytes: [u8; 4]) -> u32 {
    match order {
        Endianness::Big => u32::from_be_bytes(bytes),
        Endianness::Little => u32::from_le_bytes(bytes),
    }
}

/// The byte order that the magic number of a section header shows.
pub(crate) fn byte_order(magic: [u8; 4]) -> Option<Endianness> {
    match &magic {
        b"\x1A\x2B\x3C\x4D" => Some(Endianness::Big),
        b"\x4D\x3C\x2B\x1A" => Some(Endianness::Little),
        _ => None,
    }
}

/// Whether these are the first bytes of a section header, whose type is the same in both byte orders.
pub(crate) const fn is_section(bytes: &[u8; FRAMING]) -> bool {
    let [a, b, c, d, ..] = *bytes;
    u32::from_le_bytes([a, b, c, d]) == SECTION_HEADER_BLOCK
}

/// The length in the first bytes of a block.
pub(crate) fn length(order: Endianness, bytes: &[u8; FRAMING]) -> u32 {
    let [_, _, _, _, a, b, c, d, ..] = *bytes;
    word(order, [a, b, c, d])
}

/// The first fields of a block, and its byte order; a section header gives its own byte order.
pub(crate) fn head(section: Option<Endianness>, bytes: &[u8; FRAMING]) -> Option<(Endianness, Head)> {
    let &[kind, length, third] = bytes.as_chunks().0 else { return None };
    let order = if is_section(bytes) { byte_order(third) } else { section }?;
    Some((order, Head { kind: word(order, kind), length: word(order, length) }))
}

/// Parses the block at the beginning of the bytes.
pub(crate) fn raw(order: Endianness, bytes: &[u8]) -> Result<(&[u8], RawBlock<'_>), RawBlockParseError> {
    match order {
        Endianness::Big => RawBlock::from_slice::<BigEndian>(bytes),
        Endianness::Little => RawBlock::from_slice::<LittleEndian>(bytes),
    }
}

/// Parses the content of a block. If only its options, which begin after `fixed` bytes, are unreadable, the content is
/// returned without them; the flag tells whether the options were readable.
pub(crate) fn content<'a, T: PcapNgBlock<'a>>(
    order: Endianness,
    state: &PcapNgState,
    body: &'a [u8],
    fixed: usize,
) -> Result<(T, bool), BlockContentParseError> {
    let parse = |body| match order {
        Endianness::Big => T::from_slice::<BigEndian>(state, body),
        Endianness::Little => T::from_slice::<LittleEndian>(state, body),
    };
    match parse(body) {
        Ok((rest, block)) => Ok((block, rest.is_empty())),
        Err(error @ BlockContentParseError::Option(_)) => {
            let Some(body) = body.get(..fixed) else { return Err(error) };
            parse(body).map(|(_, block)| (block, false))
        }
        Err(error) => Err(error),
    }
}

/// The offset of a packet's options.
pub(crate) fn options_of_packet(order: Endianness, body: &[u8]) -> usize {
    let captured = body.get(12..16).and_then(|bytes| bytes.try_into().ok()).map_or(0, |bytes| word(order, bytes));
    20_usize.saturating_add(captured as usize).saturating_add(3) / 4 * 4
}

/// Whether the content of a block without frame fits its type, as far as the type is known. If not, the block may be
/// a packet with a damaged type.
pub(crate) fn is_aside(order: Endianness, state: &PcapNgState, kind: u32, body: &[u8]) -> bool {
    use pcap_file::pcapng::blocks::name_resolution::NameResolutionBlock;
    match kind {
        NAME_RESOLUTION_BLOCK => {
            content::<NameResolutionBlock<'_>>(order, state, body, body.len()).is_ok_and(|(_, whole)| whole)
        }
        // Field names of systemd consist of capital letters.
        SYSTEMD_JOURNAL_EXPORT_BLOCK => body.first().is_some_and(|&b| b.is_ascii_uppercase() || b == b'_'),
        DECRYPTION_SECRETS => {
            let length = body.get(4..8).and_then(|bytes| bytes.try_into().ok()).map(|bytes| word(order, bytes));
            length.is_some_and(|length| length as usize <= body.len() - 8)
        }
        CUSTOM_BLOCK_COPIABLE | CUSTOM_BLOCK_NON_COPIABLE => body.len() >= 4,
        _ => false,
    }
}

/// An option's code and value.
type BlockOption<'a> = (u16, &'a [u8]);

/// Calls `each` for each option; returns whether all options are readable.
pub(crate) fn for_each_option<'a>(
    order: Endianness,
    mut options: &'a [u8],
    mut each: impl FnMut(u16, &'a [u8]),
) -> bool {
    while let Some((option, rest)) = option(order, options) {
        let (code, value) = option;
        if code == 0 {
            return true;
        }
        each(code, value);
        options = rest;
    }
    options.is_empty()
}

fn option(order: Endianness, options: &[u8]) -> Option<(BlockOption<'_>, &[u8])> {
    let (&[code, length], rest) = options.as_chunks::<2>().0.first_chunk().zip(options.get(4..))?;
    let [code, length] = [code, length].map(|bytes| match order {
        Endianness::Big => u16::from_be_bytes(bytes),
        Endianness::Little => u16::from_le_bytes(bytes),
    });
    let value = rest.get(..usize::from(length))?;
    // The last option may lack its filling.
    Some(((code, value), rest.get(usize::from(length).next_multiple_of(4)..).unwrap_or_default()))
}

/// The direction of a packet by bits 0 and 1 of its flags: 1 inbound, 2 outbound.
pub(crate) const fn flags_direction(flags: u32) -> Direction {
    match flags & 3 {
        1 => Direction::Rx,
        2 => Direction::Tx,
        _ => Direction::Unknown,
    }
}
