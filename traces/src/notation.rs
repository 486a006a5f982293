//! candump's notation of a frame, used in its log, by `cansend` and by canvass itself.
//!
//! ```text
//! frame    = standard | extended | error | xl
//! standard = ID3 "#" body              three digits: 11 bits
//! extended = ID8 "#" body              eight digits: 29 bits
//! error    = ID8 "#" data              bit 2000 0000h set: an error frame, the rest are its class bits
//! body     = data | data8 "_" RAW | remote | "#" FLAGS fd-data
//! remote   = ("R" | "r") [LEN] | ("R" | "r") "8_" RAW
//! data     = up to 8 bytes, each two hex digits, with or without "." between them
//! xl       = VCID2 PRIORITY3 "#" FLAGS2 ":" SDT2 ":" AF8 "#" data      five digits: CAN XL
//! ```
//!
//! - The **number of id digits** decides the kind; no other number is valid.
//! - RAW is the raw data length code 9 to F of a classical frame with 8 bytes.
//! - FLAGS of CAN FD: BRS 1, ESI 2, FDF 4. Older tools leave the last one out, though `##` alone says CAN FD;
//!   bit 8 has no meaning and is ignored. CAN FD has no remote frames.
//! - FLAGS of CAN XL: XLF 80h, which must be set, SEC 1, RRS 2.
//! - A point may also stand before the first byte, as some versions write it after the CAN FD flags.

use crate::grammar::{Expected, Parsed, eight_bytes, hex_byte, hex_field, hex_run, nibble, tag, whole};
use crate::hex::write_hex;
use crate::{CanId, ChannelId, ErrorClass, Flags, Frame, Record, Timestamp, XlHeader};
use std::fmt::{self, Write};

/// Bit 29 of an eight-digit id: the frame is an error frame.
const ERROR: u32 = Frame::ERROR_FLAG;
const XL_FLAG: u8 = 0x80;
const XL_SEC: u8 = 0x01;
const XL_RRS: u8 = 0x02;

/// Why a text is no frame.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
#[error("at position {}: expected {expected}{}", position + 1, after(found))]
pub struct FrameSyntax {
    /// Offset of the error in bytes; the text's length if it ends too early.
    pub position: usize,
    /// The expected text.
    pub expected: &'static str,
    /// The text found instead, cut to a readable length.
    pub found: String,
}

fn after(found: &str) -> String {
    if found.is_empty() { ", but the text ends".to_owned() } else { format!(", found \"{found}\"") }
}

/// Parses a frame in candump's notation, such as `63F#4000600000000000`, `701#R`, `123##5AABB`, and gives a record of
/// channel 0 at time zero.
///
/// # Errors
/// [`FrameSyntax`] with the place of the error and the expected text.
///
/// ```
/// use canvass_traces::{FrameKind, parse_frame};
///
/// let upload_of_1000h = parse_frame("601#4000100000000000")?;
/// assert_eq!(upload_of_1000h.frame.cob_id(), Some(0x601));
/// assert_eq!(upload_of_1000h.frame.data(), [0x40, 0x00, 0x10, 0, 0, 0, 0, 0]);
/// assert_eq!(parse_frame("701#R1")?.frame.kind(), FrameKind::Remote);
/// assert!(parse_frame("601#4").is_err(), "half a byte");
/// # Ok::<(), canvass_traces::FrameSyntax>(())
/// ```
pub fn parse_frame(text: &str) -> Result<Record, FrameSyntax> {
    let bytes = text.as_bytes();
    whole(frame(bytes), "the end of the text after the frame").map_err(|missing| {
        let position = bytes.len().saturating_sub(missing.at.len());
        let rest = text.get(position..).unwrap_or_default();
        let found = rest.chars().take(40).map(|c| if c.is_control() { '\u{FFFD}' } else { c }).collect();
        FrameSyntax { position, expected: missing.what, found }
    })
}

/// An identifier in candump's notation; the number of digits determines its kind.
pub(crate) enum Identifier {
    /// Three or eight digits.
    Frame(CanId),
    /// Eight digits with bit 29 set: the class of an error frame.
    Error(ErrorClass),
    /// Five digits: the network and priority of CAN XL.
    Xl(u32),
}

/// Parses an identifier in candump's notation.
#[inline(always)]
pub(crate) fn identifier(input: &[u8]) -> Parsed<'_, Identifier> {
    let (rest, digits, id) = hex_run(input);
    let identifier = match digits {
        3 => match CanId::standard(id) {
            Some(id) => Identifier::Frame(id),
            None => return Expected::fail(input, "an 11-bit id of at most 7FF"),
        },
        8 if id & !(ERROR | CanId::MAX_EXTENDED) != 0 => {
            return Expected::fail(
                input,
                "a 29-bit id of at most 1FFFFFFF, or an error frame's class with bit 20000000",
            );
        }
        8 if id & ERROR != 0 => Identifier::Error(ErrorClass(id & !ERROR)),
        8 => Identifier::Frame(CanId::extended_masked(id)),
        5 => Identifier::Xl(id),
        // The error is at the first wrong character, or at the beginning if the number of digits is wrong.
        _ if !matches!(rest, [b'#' | b' ', ..]) && digits < 8 => {
            return Expected::fail(rest, "a hex digit of the id or '#'");
        }
        _ => return Expected::fail(input, "an id of 3 digits (11 bits), 8 digits (29 bits) or 5 digits (CAN XL)"),
    };
    Ok((rest, identifier))
}

/// Parses a frame in candump's notation.
#[inline(always)]
pub(crate) fn frame(input: &[u8]) -> Parsed<'_, Record> {
    let (rest, id) = identifier(input)?;
    let [b'#', body @ ..] = rest else { return Expected::fail(rest, "'#' after the id") };
    match id {
        Identifier::Frame(id) => classical_or_fd(id, body),
        Identifier::Error(class) => error(class, body),
        Identifier::Xl(id) => xl(id, body),
    }
}

fn record(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

#[inline(always)]
fn classical_or_fd(id: CanId, body: &[u8]) -> Parsed<'_, Record> {
    match body {
        [b'R' | b'r', len @ ..] => remote(id, len),
        [b'#', fd_body @ ..] => fd(id, fd_body),
        _ => {
            if let Some((data, rest)) = eight_bytes(body)
                && !matches!(rest, [b'.', ..] | [b'0'..=b'9', ..] | [b'A'..=b'F', ..] | [b'a'..=b'f', ..])
            {
                return raw_dlc(Frame::full(id, data), rest);
            }
            let (rest, (data, len)) = payload::<8>(body, "at most 8 data bytes")?;
            if len < 8 {
                let frame = data.get(..len).and_then(|data| Frame::new(id, data));
                return frame.map_or_else(|| Expected::fail(body, "data"), |frame| Ok((rest, record(frame))));
            }
            raw_dlc(Frame::full(id, data), rest)
        }
    }
}

/// Parses the raw data length code `_9` to `_F` of a frame with eight bytes.
#[inline]
fn raw_dlc(frame: Frame, input: &[u8]) -> Parsed<'_, Record> {
    match input {
        [b'_', digit, rest @ ..] => match nibble(*digit) {
            Some(dlc @ 9..) => Ok((rest, record(frame.with_raw_dlc(dlc)))),
            _ => Expected::fail(&input[1..], "a raw data length code of 9 to F"),
        },
        [b'_', ..] => Expected::fail(&input[1..], "a raw data length code of 9 to F"),
        _ => Ok((input, record(frame))),
    }
}

#[inline(never)]
fn remote(id: CanId, input: &[u8]) -> Parsed<'_, Record> {
    let (rest, len) = match input {
        [digit @ b'0'..=b'9', rest @ ..] => (rest, digit - b'0'),
        _ => (input, 0),
    };
    match Frame::remote(id, len) {
        Some(frame) if len == 8 => raw_dlc(frame, rest),
        Some(frame) => Ok((rest, record(frame))),
        None => Expected::fail(input, "a remote frame's length of 0 to 8"),
    }
}

#[inline(never)]
fn fd(id: CanId, input: &[u8]) -> Parsed<'_, Record> {
    let [flags, body @ ..] = input else { return Expected::fail(input, "a hex digit with the CAN FD flags") };
    let Some(flags) = nibble(*flags) else { return Expected::fail(input, "a hex digit with the CAN FD flags") };
    let (rest, (data, len)) = payload::<64>(body, "at most 64 data bytes")?;
    let data = data.get(..len).unwrap_or_default();
    match Record::fd(Timestamp::ZERO, ChannelId(0), id, Flags::from_bits(flags), data) {
        Some(record) => Ok((rest, record)),
        None => Expected::fail(rest, "a length that CAN FD has: 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes"),
    }
}

#[inline(never)]
fn error(class: ErrorClass, body: &[u8]) -> Parsed<'_, Record> {
    let (rest, (data, len)) = payload::<8>(body, "at most 8 bytes of an error frame")?;
    let frame = data.get(..len).and_then(|data| Frame::error(class, data));
    frame.map_or_else(|| Expected::fail(body, "data"), |frame| Ok((rest, record(frame))))
}

#[inline(never)]
fn xl(id: u32, input: &[u8]) -> Parsed<'_, Record> {
    let (rest, flags) = hex_field(2, "two hex digits with the CAN XL flags")(input)?;
    let (rest, ()) = tag(b":", "':' after the CAN XL flags")(rest)?;
    let (rest, sdt) = hex_field(2, "two hex digits with the payload type (SDT)")(rest)?;
    let (rest, ()) = tag(b":", "':' after the payload type")(rest)?;
    let (rest, af) = hex_field(8, "eight hex digits with the acceptance field")(rest)?;
    let (body, ()) = tag(b"#", "'#' after the acceptance field")(rest)?;
    let Some((priority, header)) = xl_header(id, flags as u8, sdt as u8, af) else {
        return Expected::fail(input, "CAN XL flags with bit 80 set, and a priority of at most 7FF");
    };
    let (rest, (data, len)) = payload::<2048>(body, "at most 2048 data bytes")?;
    match Record::xl(Timestamp::ZERO, ChannelId(0), priority, header, data.get(..len).unwrap_or_default()) {
        Some(record) => Ok((rest, record)),
        None => Expected::fail(body, "at least one byte, as every CAN XL frame has"),
    }
}

/// Priority and header of CAN XL. The lower 12 bits of `id` are the priority, the bits above the virtual CAN network.
pub(crate) fn xl_header(id: u32, flags: u8, sdt: u8, af: u32) -> Option<(CanId, XlHeader)> {
    let priority = CanId::standard(id & 0xFFF)?;
    let header = XlHeader { vcid: (id >> 12) as u8, sec: flags & XL_SEC != 0, rrs: flags & XL_RRS != 0, sdt, af };
    (flags & XL_FLAG != 0).then_some((priority, header))
}

/// Parses up to `MAX` bytes in hex, with or without a point before each; returns also their number.
#[inline(never)]
fn payload<'a, const MAX: usize>(input: &'a [u8], limit: &'static str) -> Parsed<'a, ([u8; MAX], usize)> {
    let mut data = [0; MAX];
    let mut len = 0;
    let mut rest = input;
    loop {
        let next = match rest {
            [b'.', next @ ..] => next,
            [digit, ..] if nibble(*digit).is_some() => rest,
            _ => return Ok((rest, (data, len))),
        };
        let Some(place) = data.get_mut(len) else { return Expected::fail(rest, limit) };
        (rest, *place) = hex_byte(next)?;
        len += 1;
    }
}

/// A record's complete frame in candump's notation; [`parse_frame`] reads it back.
#[derive(Clone, Copy, Debug)]
pub struct Notation<'a>(&'a Record);

impl Record {
    /// The frame in candump's notation, with its whole payload.
    pub fn notation(&self) -> Notation<'_> {
        Notation(self)
    }
}

impl fmt::Display for Notation<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_frame(f, &self.0.frame, self.0.xl_header(), self.0.data())
    }
}

/// The notation of candump's log and of `cansend`: `63F#4000600000000000`, `701#R`, `123##5AABB`.
///
/// A [head](Frame::is_head) of a longer frame is written with its bytes and `…`; [`Record::notation`] writes the whole
/// frame.
impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_frame(f, self, None, self.data())?;
        if self.is_head() { f.write_str("…") } else { Ok(()) }
    }
}

/// Writes a frame with the payload `data`.
pub(crate) fn write_frame(out: &mut impl Write, frame: &Frame, xl: Option<XlHeader>, data: &[u8]) -> fmt::Result {
    if let Some(xl) = xl {
        let flags = XL_FLAG | if xl.sec { XL_SEC } else { 0 } | if xl.rrs { XL_RRS } else { 0 };
        write!(out, "{:02X}{:03X}#{flags:02X}:{:02X}:{:08X}#", xl.vcid, frame.id().raw(), xl.sdt, xl.af)?;
        return write_bytes(out, data);
    }
    match frame.is_error() {
        true => write!(out, "{:08X}#", frame.printed_id())?,
        false => write!(out, "{}#", frame.id())?,
    }
    if frame.is_remote() {
        out.write_char('R')?;
        if !frame.is_empty() {
            write!(out, "{}", frame.len())?;
        }
    } else if frame.is_fd() {
        write!(out, "#{:X}", frame.flags().bits())?;
    }
    write_bytes(out, data)?;
    if frame.flags() == Flags::NONE && frame.dlc() > 8 {
        write!(out, "_{:X}", frame.dlc())?;
    }
    Ok(())
}

fn write_bytes(out: &mut impl Write, data: &[u8]) -> fmt::Result {
    data.iter().try_for_each(|&byte| write_hex(out, byte))
}
