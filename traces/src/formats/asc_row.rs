//! The rows of Vector ASC after their times.

use crate::grammar::{Expected, Parsed, decimal, hex_byte, nibble, skip_blanks, word};
use crate::{CanId, ChannelId, Direction, ErrorClass, Flags, Frame, Record, Timestamp};

/// The base of ids and data.
#[derive(Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Radix {
    #[default]
    Hexadecimal,
    Decimal,
}

/// The content of a row.
pub(crate) enum AscRow<'a> {
    Frame {
        channel: &'a [u8],
        record: Record,
        /// Whether the file may have been cut inside the data, if this line is the last one.
        in_doubt: bool,
    },
    /// A request to send a frame.
    Request,
    /// An event that is no frame.
    Event,
    /// A row that is neither a supported frame nor a known event.
    Unknown,
}

/// The first words of rows without frames: the other events that CANoe and CANalyzer log.
const EVENTS: &[&[u8]] = &[
    b"Start", // of measurement
    b"Begin", // Triggerblock
    b"End",   // TriggerBlock
    b"log",   // direct start, direct stop, trigger event
    b"Log",   // Trigger Event
    b"SV:",   // a system variable
    b"TFS:",  // a step of a test
    b"TE:",   // the same
    b"Comment:",
    b"Trigger",
    b"GPS-Device:",
    b"GMGroup", // a marker
    b"Li",      // LIN and FlexRay, Ethernet, avionics, K-Line
    b"Fr",
    b"ETH",
    b"A429",
    b"AFDX",
    b"KLine",
];

/// The words after the channel in rows without frames.
const CHANNEL_EVENTS: &[&[u8]] = &[b"Statistic:", b"J1939TP", b"J1939PG", b"OverloadFrame"];

/// The class of an error frame without details: a bus error, as Linux numbers it.
pub(crate) const BUS_ERROR: ErrorClass = ErrorClass(0x80);

/// Flag of `CANFD` rows: the frame is remote.
pub(crate) const FLAG_REMOTE: u32 = 0x10;
/// Flag of `CANFD` rows: the frame is CAN FD.
pub(crate) const FLAG_FDF: u32 = 0x1000;
/// Flag of `CANFD` rows: the bit rate was switched.
pub(crate) const FLAG_BRS: u32 = 0x2000;
/// Flag of `CANFD` rows: the sender is error passive.
pub(crate) const FLAG_ESI: u32 = 0x4000;

/// Parses a row after its time.
pub(crate) fn row(input: &[u8], radix: Radix) -> Parsed<'_, AscRow<'_>> {
    let (rest, first) = next_word(input, "an event")?;
    match first {
        b"CANFD" => fd_row(rest, radix),
        _ if first.iter().all(u8::is_ascii_digit) => classical_row(rest, first, radix),
        _ if is_event(first, rest) => Ok((rest, AscRow::Event)),
        _ => Ok((rest, AscRow::Unknown)),
    }
}

/// Whether a row with this first word, followed by `rest`, is known to hold no frame.
fn is_event(first: &[u8], rest: &[u8]) -> bool {
    let mut words = rest.split(|&b| b == b' ' || b == b'\t').filter(|word| !word.is_empty());
    let (second, third) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    match first {
        // A row such as `CAN 1 Status:chip status error active`.
        b"CAN" => second.iter().all(u8::is_ascii_digit) && third.starts_with(b"Status:"),
        // LIN channels are L1, L2 and so on.
        [b'L', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) => true,
        // A row such as `EnvSpeed := 12` sets an environment variable.
        _ => second == b":=" || EVENTS.contains(&first),
    }
}

fn next_word<'a>(input: &'a [u8], what: &'static str) -> Parsed<'a, &'a [u8]> {
    word(what)(skip_blanks(input))
}

fn direction(word: &[u8]) -> Option<Direction> {
    match word {
        b"Rx" => Some(Direction::Rx),
        b"Tx" => Some(Direction::Tx),
        _ => None,
    }
}

fn classical_row<'a>(input: &'a [u8], channel: &'a [u8], radix: Radix) -> Parsed<'a, AscRow<'a>> {
    let (rest, id) = next_word(input, "an id")?;
    if id.eq_ignore_ascii_case(b"ErrorFrame") {
        return Ok((rest, error_frame(channel, Direction::Unknown)));
    }
    if CHANNEL_EVENTS.contains(&id) {
        return Ok((rest, AscRow::Event));
    }
    let id = identifier(id, radix)?;
    let (rest, word) = next_word(rest, "Rx, Tx or TxRq")?;
    let direction = match direction(word) {
        Some(direction) => direction,
        None if word == b"TxRq" => return Ok((rest, AscRow::Request)),
        None => return Expected::fail(word, "Rx, Tx or TxRq"),
    };
    let (rest, kind) = next_word(rest, "d (data) or r (remote)")?;
    match kind {
        b"d" | b"D" => {
            let (rest, dlc) = dlc(rest)?;
            let (rest, data) = bytes(rest, usize::from(dlc.min(8)), radix)?;
            no_more_bytes(rest)?;
            let Some(frame) = Frame::new(id, &data) else { return Expected::fail(rest, "at most 8 bytes") };
            // The decimal number at the end of the line may have more digits.
            let in_doubt = rest.is_empty() && radix == Radix::Decimal && !data.is_empty();
            Ok((rest, frame_row(channel, frame.with_raw_dlc(dlc), direction, in_doubt)))
        }
        b"r" | b"R" => {
            let (behind, dlc) = dlc(rest).unwrap_or((rest, 0));
            no_more_bytes(behind)?;
            let Some(frame) = Frame::remote(id, dlc.min(8)) else { return Expected::fail(rest, "a length") };
            let in_doubt = skip_blanks(rest).is_empty();
            Ok((behind, frame_row(channel, frame.with_raw_dlc(dlc), direction, in_doubt)))
        }
        _ => Expected::fail(kind, "d (data) or r (remote)"),
    }
}

fn frame_row(channel: &[u8], frame: Frame, direction: Direction, in_doubt: bool) -> AscRow<'_> {
    let record = Record::new(Timestamp::ZERO, ChannelId(0), frame).with_direction(direction);
    AscRow::Frame { channel, record, in_doubt }
}

fn error_frame(channel: &[u8], direction: Direction) -> AscRow<'_> {
    match Frame::error(BUS_ERROR, &[]) {
        Some(frame) => frame_row(channel, frame, direction, false),
        None => AscRow::Event,
    }
}

/// Parses a row such as `CANFD 1 Rx 7d Name 1 0 9 12 …`.
fn fd_row(input: &[u8], radix: Radix) -> Parsed<'_, AscRow<'_>> {
    let (rest, channel) = next_word(input, "a channel")?;
    let (at, word) = next_word(rest, "Rx or Tx")?;
    let direction = match direction(word) {
        Some(direction) => direction,
        None if word == b"TxRq" => return Ok((at, AscRow::Request)),
        None => return Expected::fail(word, "Rx, Tx or TxRq"),
    };
    let (rest, id) = next_word(at, "an id")?;
    if id.eq_ignore_ascii_case(b"ErrorFrame") {
        return Ok((rest, error_frame(channel, direction)));
    }
    let id = identifier(id, radix)?;
    let (behind, name_or_brs) = next_word(rest, "a name, or BRS")?;
    let rest = if matches!(name_or_brs, b"0" | b"1") { rest } else { behind };
    let (rest, brs) = switch(rest, "BRS, 0 or 1")?;
    let (rest, esi) = switch(rest, "ESI, 0 or 1")?;
    let (rest, dlc) = dlc(rest)?;
    let (rest, len) = decimal("a length")(skip_blanks(rest))?;
    if len > 64 {
        return Expected::fail(rest, "at most 64 bytes");
    }
    let (rest, data) = bytes(rest, len as usize, radix)?;
    let (behind, flags) = row_flags(rest);
    let flags_of_frame = if brs { Flags::BRS } else { Flags::NONE }.with(if esi { Flags::ESI } else { Flags::NONE });
    let is_remote = flags.is_some_and(|flags| flags & FLAG_REMOTE != 0) || len == 0 && dlc > 0;
    let is_fd = flags.is_none_or(|flags| flags & FLAG_FDF != 0) || brs || len > 8;
    let record = match () {
        () if is_remote => Frame::remote(id, dlc.min(8)).map(|frame| at_zero(frame.with_raw_dlc(dlc))),
        () if is_fd => Record::fd(Timestamp::ZERO, ChannelId(0), id, flags_of_frame, &data),
        () => Frame::new(id, &data).map(|frame| at_zero(frame.with_raw_dlc(dlc))),
    };
    match record {
        Some(record) => {
            let record = record.with_direction(direction);
            Ok((behind, AscRow::Frame { channel, record, in_doubt: flags.is_none() || behind.is_empty() }))
        }
        None => Expected::fail(rest, "a length that CAN FD has: 0 to 8, 12, 16, 20, 24, 32, 48 or 64 bytes"),
    }
}

fn at_zero(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

/// The flags after duration and bit count, if the row has them.
fn row_flags(input: &[u8]) -> (&[u8], Option<u32>) {
    let third = || {
        let (rest, _) = next_word(input, "a duration").ok()?;
        let (rest, _) = next_word(rest, "a bit count").ok()?;
        let (rest, flags) = next_word(rest, "flags").ok()?;
        let flags = std::str::from_utf8(flags).ok()?;
        Some((rest, u32::from_str_radix(flags, 16).ok()?))
    };
    third().map_or((input, None), |(rest, flags)| (rest, Some(flags)))
}

/// Parses an id, which ends in `x` if it has 29 bits.
fn identifier(word: &[u8], radix: Radix) -> Result<CanId, nom::Err<Expected<'_>>> {
    let wrong = |what| Err(nom::Err::Error(Expected::new(word, what)));
    let (digits, extended) = match word {
        [digits @ .., b'x' | b'X'] => (digits, true),
        _ => (word, false),
    };
    let Some(raw) = number(digits, radix) else { return wrong("an id") };
    let id = if extended { CanId::extended(raw) } else { CanId::standard(raw) };
    match id {
        Some(id) => Ok(id),
        None if extended => wrong("a 29-bit id of at most 1FFFFFFF"),
        None => wrong("an 11-bit id of at most 7FF (29-bit ids end with x)"),
    }
}

fn number(digits: &[u8], radix: Radix) -> Option<u32> {
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_alphanumeric) {
        return None;
    }
    let radix = if radix == Radix::Decimal { 10 } else { 16 };
    u32::from_str_radix(std::str::from_utf8(digits).ok()?, radix).ok()
}

/// Parses the DLC, one hex digit.
fn dlc(input: &[u8]) -> Parsed<'_, u8> {
    let (rest, word) = next_word(input, "a DLC of one hex digit")?;
    let code = if let [digit] = word { nibble(*digit) } else { None };
    match code {
        Some(code) => Ok((rest, code)),
        None => Expected::fail(word, "a DLC of one hex digit"),
    }
}

fn switch<'a>(input: &'a [u8], what: &'static str) -> Parsed<'a, bool> {
    let (rest, word) = next_word(input, what)?;
    match word {
        b"0" => Ok((rest, false)),
        b"1" => Ok((rest, true)),
        _ => Expected::fail(word, what),
    }
}

/// Parses `count` bytes separated by spaces.
fn bytes(input: &[u8], count: usize, radix: Radix) -> Parsed<'_, Vec<u8>> {
    let mut data = Vec::with_capacity(count);
    let mut rest = input;
    while data.len() < count {
        let (behind, byte) = match radix {
            Radix::Hexadecimal => hex_byte(skip_blanks(rest))?,
            Radix::Decimal => {
                let (behind, word) = next_word(rest, "a byte")?;
                match number(word, radix).and_then(|n| u8::try_from(n).ok()) {
                    Some(byte) => (behind, byte),
                    None => return Expected::fail(word, "a byte of 0 to 255"),
                }
            }
        };
        if !matches!(behind, [] | [b' ' | b'\t', ..]) {
            return Expected::fail(behind, "a space after the byte");
        }
        data.push(byte);
        rest = behind;
    }
    Ok((rest, data))
}

/// Checks that the data ends: words or long numbers may follow, but no further byte.
fn no_more_bytes(input: &[u8]) -> Result<(), nom::Err<Expected<'_>>> {
    match next_word(input, "a word") {
        Ok((_, word @ [high, low])) if nibble(*high).is_some() && nibble(*low).is_some() => {
            Err(nom::Err::Error(Expected::new(word, "no more bytes than the DLC tells")))
        }
        _ => Ok(()),
    }
}
