//! The output of candump on a console, which `log2long` writes too.
//!
//! ```text
//! line  = [stamp] IFACE [("RX" | "TX") ("B" | "-") ("E" | "-")] ID body [text]
//! stamp = "(" SECONDS ")" | "(" YYYY-MM-DD hh:mm:ss.ffffff ")"
//! body  = "[" LEN "]" bytes | "[" LEN "]" "remote request" | "[" LEN "]" "(" VCID "|" FLAGS ":" SDT ":" AF ")" bytes
//! text  = "ERRORFRAME" | "'ASCII'" | "`IICSA`" | remark
//! ```
//!
//! Pitfalls:
//!
//! - **One digit in the brackets is classical CAN, two are CAN FD, four are CAN XL.** Braces (`-8`) hold the raw data
//!   length code. The number of a remote frame is the requested length.
//! - Without `-x` the output lacks the flags BRS and ESI of CAN FD; they are read as clear.
//! - With `-S` the bytes are in reverse order, separated by backticks; with `-i` they are bits; with `-c` the output
//!   has colours. The text of `-a` may hold quotes itself; it only repeats the data and is ignored.
//! - Dates (`-tA`) are in the recorder's local time. Small numbers count from the first frame (`-tz`) or from the frame
//!   before (`-td`), and the output does not say which. Differences decrease again and again, so the lines buffered at
//!   the beginning decide; if they are few, the first number that is less than the one before decides.
//! - A comment (`#`, `;`) that is a frame except for its first byte is reported: the byte may be a damaged space.
//! - What somebody wrote after the bytes (`<-- here`, `// no answer`) is a remark, and becomes the record's comment, unless
//!   it begins like a byte or holds a frame. After `[0]` a mark must begin it: words may be a damaged `remote request`.
//! - candump itself cuts more than 64 bytes of CAN XL (`...`): the frame is reported as truncated.
//!
//! In a last line without line end the number in the brackets tells whether all bytes are there. Two doubts
//! remain: `[0]` may be cut before `remote request`, and a single byte `10` may be the beginning of bits; such
//! lines are reported as truncated.

mod behind;
mod clock;

use crate::formats::candump_log::{aside, intern};
use crate::grammar::{
    Expected, Parsed, billionths, blanks1, decimal, hex_byte, hex_field, nibble, seconds, skip_blanks, tag, word,
};
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::notation::{Identifier, identifier, xl_header};
use crate::{
    ChannelId, Channels, Damage, DamageKind, Direction, ErrorClass, Flags, Frame, ReadOptions, Reader, Record, Source,
    TimeBase, Timestamp,
};
use behind::{Behind, NO_SURPLUS, behind, remarked};
use clock::Clock;
use jiff::civil;
use memchr::memchr;
use nom::Parser;
use nom::branch::alt;
use nom::combinator::{opt, value};
use nom::sequence::{delimited, preceded, terminated};
use std::borrow::Cow;

const SNIFF_LINES: usize = 200;

pub(crate) fn sniff(head: &[u8]) -> bool {
    let lines = || head_lines(head).take(SNIFF_LINES).map(|(line, _)| without_colours(line));
    let rows = lines().filter(|line| is_row(line)).count();
    // A row of candump in a text of another tool does not decide.
    rows > 0 && 2 * rows >= lines().filter(|line| has_length(line)).count()
}

/// Whether the line begins like one of candump. A name without a number may be any word of a text if no frame follows.
fn is_row(line: &[u8]) -> bool {
    let Ok((rest, start)) = start(line) else { return false };
    start.brackets
        && may_be_interface(start.name)
        && (start.name.last().is_some_and(u8::is_ascii_digit) || body(rest, start.id, start.flags).is_ok())
}

/// Whether the line has a length in brackets or braces, with a blank before and after it.
fn has_length(line: &[u8]) -> bool {
    let mut words = line.split(|byte| *byte == b' ');
    words.any(
        |word| matches!(word, [b'[', digits @ .., b']'] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit)),
    )
}

/// Whether the word before an identifier may be the name of an interface: rows of other tools have a time or a direction
/// there.
fn may_be_interface(name: &[u8]) -> bool {
    const OTHERS: [&[u8]; 7] = [b"rx", b"tx", b"r", b"t", b"id", b"recv", b"send"];
    name.first().is_some_and(u8::is_ascii_alphabetic) && !OTHERS.iter().any(|other| name.eq_ignore_ascii_case(other))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(TextReader::new(source, Console::default()))
}

#[derive(Default)]
struct Console {
    clock: Clock,
    /// Whether the last frame was an error frame: candump may print an explanation after an error frame.
    explained: bool,
    /// Whether an earlier line has proved that the bytes are hexadecimal.
    hexadecimal: bool,
}

impl LineFormat for Console {
    fn begin(&mut self, head: &[u8]) {
        self.clock = Clock::guess(head);
    }

    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        let plain = without_colours(line.bytes);
        let line = Line { bytes: &plain, ..*line };
        match aside(&line, self.explained, is_frame) {
            Some(damage) => damage.map(Err),
            None => Some(self.frame_line(&line, channels)),
        }
    }

    fn time_base(&self) -> TimeBase {
        self.clock.base()
    }
}

/// Whether the bytes after the first byte of a line are those of a frame. The first byte should be a space.
fn is_frame(behind: &[u8]) -> bool {
    let whole = |line: &[u8]| start(line).is_ok_and(|(rest, start)| body(rest, start.id, start.flags).is_ok());
    // In a line with a time, the damaged first byte is the parenthesis.
    whole(behind) || whole(&[b"(", behind].concat())
}

impl Console {
    fn frame_line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Result<Record, Damage> {
        let damage = |error| line.damage(Expected::from(error));
        let (rest, start) = start(line.bytes).map_err(damage)?;
        let (_, body) = body(rest, start.id, start.flags).map_err(damage)?;
        if body.cropped {
            let what = "all bytes of the CAN XL frame, of which candump's console shows 64";
            return Err(line.as_damage(DamageKind::Truncated, what));
        }
        let in_doubt = body.doubt == Doubt::Remote || body.doubt == Doubt::Bits && !self.hexadecimal;
        if !line.ended && in_doubt {
            return Err(line.cut("the end of this line, as the frame may go on,"));
        }
        let mut record = body.record;
        self.hexadecimal |= !record.frame.is_empty() && body.doubt == Doubt::None && !body.bits;
        record.channel = intern(start.name, channels).map_err(|missing| line.damage(missing))?;
        record.timestamp = self.clock.time(start.stamp);
        record.direction = start.direction;
        record.place = line.place;
        self.explained = record.frame.is_error();
        match body.behind {
            Behind::Usual => Ok(record),
            Behind::Remark(text) => Ok(remarked(record, text)),
            // A controller obeys the length code: if the line is right at all, the bus carried this number of bytes.
            Behind::Surplus(at) => Err(line.damage(Expected { at, what: NO_SURPLUS }).with_salvaged(record)),
        }
    }
}

/// Removes the escape sequences of colours.
fn without_colours(line: &[u8]) -> Cow<'_, [u8]> {
    if memchr(0x1B, line).is_none() {
        return line.into();
    }
    let mut plain = Vec::with_capacity(line.len());
    let mut rest = line;
    while let Some(at) = memchr(0x1B, rest) {
        let (text, escape) = rest.split_at(at);
        plain.extend_from_slice(text);
        let end = escape.iter().position(|b| b.is_ascii_alphabetic());
        rest = end.and_then(|end| escape.get(end + 1..)).unwrap_or_default();
    }
    plain.extend_from_slice(rest);
    plain.into()
}

/// The part of a line before the brackets.
struct Start<'a> {
    stamp: Option<Stamp>,
    name: &'a [u8],
    direction: Direction,
    flags: Flags,
    id: Identifier,
    brackets: bool,
}

#[derive(Clone, Copy)]
enum Stamp {
    Seconds(u64),
    /// A date: nanoseconds since 1970 in local time.
    Date(u64),
}

fn start(input: &[u8]) -> Parsed<'_, Start<'_>> {
    let (rest, stamp) = opt(terminated(stamp, blanks1)).parse(skip_blanks(input))?;
    if let (None, [b'(', inside @ ..]) = (stamp, rest) {
        return Expected::fail(inside, "a time in seconds or a date, and ')'");
    }
    let (rest, name) = terminated(word("an interface name"), blanks1).parse(rest)?;
    let (rest, info) = opt(terminated(message_info, blanks1)).parse(rest)?;
    let (direction, flags) = info.unwrap_or((Direction::Unknown, Flags::NONE));
    let (rest, id) = terminated(identifier, blanks1).parse(rest)?;
    let brackets = matches!(rest, [b'[', b'0'..=b'9', ..]) || matches!(rest, [b'{', _, b'}', ..]);
    Ok((rest, Start { stamp, name, direction, flags, id, brackets }))
}

fn stamp(input: &[u8]) -> Parsed<'_, Stamp> {
    delimited(tag(b"(", "'('"), alt((date.map(Stamp::Date), seconds.map(Stamp::Seconds))), tag(b")", "')'"))
        .parse(input)
}

/// Parses a date such as `2025-01-28 10:47:15.123456`; gives nanoseconds since 1970 as if it were UTC.
fn date(input: &[u8]) -> Parsed<'_, u64> {
    let number = |what| decimal(what);
    let (rest, (year, month, day)) =
        (number("a year"), preceded(tag(b"-", "'-'"), number("a month")), preceded(tag(b"-", "'-'"), number("a day")))
            .parse(input)?;
    let (rest, (hour, minute, second, nanos)) = (
        preceded(blanks1, number("an hour")),
        preceded(tag(b":", "':'"), number("a minute")),
        preceded(tag(b":", "':'"), number("a second")),
        preceded(tag(b".", "'.'"), billionths),
    )
        .parse(rest)?;
    let narrow = |n: u64| i8::try_from(n).ok();
    let nanos_since_1970 = || {
        let date = civil::Date::new(i16::try_from(year).ok()?, narrow(month)?, narrow(day)?).ok()?;
        let time =
            civil::Time::new(narrow(hour)?, narrow(minute)?, narrow(second)?, i32::try_from(nanos).ok()?).ok()?;
        crate::local_time::nanos(date.to_datetime(time))
    };
    match nanos_since_1970() {
        Some(nanos) => Ok((rest, nanos)),
        None => Expected::fail(input, "a date between 1970 and 2554"),
    }
}

/// Parses the direction and the CAN FD flags, such as `TX B E`; a missing flag is a dash.
fn message_info(input: &[u8]) -> Parsed<'_, (Direction, Flags)> {
    let direction = alt((value(Direction::Rx, tag(b"RX ", "RX")), value(Direction::Tx, tag(b"TX ", "TX"))));
    let flag = |letter, flag| alt((value(flag, letter), value(Flags::NONE, tag(b"-", "'-'"))));
    let flags = (terminated(flag(tag(b"B", "B"), Flags::BRS), tag(b" ", "' '")), flag(tag(b"E", "E"), Flags::ESI));
    (direction, flags.map(|(brs, esi)| brs.with(esi))).parse(input)
}

/// The reason why a line without line end may be incomplete.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Doubt {
    None,
    /// The line may have been cut before `remote request`.
    Remote,
    /// A single byte may be the beginning of eight bits.
    Bits,
}

struct Body<'a> {
    record: Record,
    bits: bool,
    cropped: bool,
    doubt: Doubt,
    behind: Behind<'a>,
}

impl Body<'_> {
    const fn new(record: Record) -> Self {
        Self { record, bits: false, cropped: false, doubt: Doubt::None, behind: Behind::Usual }
    }
}

/// The content of the brackets, which determines the kind of frame.
#[derive(Clone, Copy)]
enum Length {
    Classical { len: u8, raw_dlc: u8 },
    Fd(u64),
    Xl(u64),
}

fn length(input: &[u8]) -> Parsed<'_, Length> {
    if let [b'{', digit, b'}', rest @ ..] = input {
        return match nibble(*digit) {
            Some(dlc) => Ok((rest, Length::Classical { len: dlc.min(8), raw_dlc: dlc })),
            None => Expected::fail(&input[1..], "a data length code"),
        };
    }
    let (digits, ()) = tag(b"[", "a length in brackets")(input)?;
    let (rest, len) = decimal("a length")(digits)?;
    let (behind, ()) = tag(b"]", "']' after the length")(rest)?;
    match digits.len() - rest.len() {
        1 if len <= 8 => Ok((behind, Length::Classical { len: len as u8, raw_dlc: 0 })),
        2 if len <= 64 => Ok((behind, Length::Fd(len))),
        4 if (1..=2048).contains(&len) => Ok((behind, Length::Xl(len))),
        _ => Expected::fail(digits, "a length of one digit (CAN), two (CAN FD) or four (CAN XL)"),
    }
}

fn body(input: &[u8], id: Identifier, flags: Flags) -> Parsed<'_, Body<'_>> {
    let (rest, length) = length(input)?;
    match (id, length) {
        (Identifier::Frame(id), Length::Classical { len, raw_dlc }) => {
            let remote = skip_blanks(rest).strip_prefix(b"remote request");
            if let (Some(rest), Some(frame)) = (remote, Frame::remote(id, len)) {
                let record = at_zero(frame.with_raw_dlc(raw_dlc));
                return Ok((rest, Body::new(record)));
            }
            payload(rest, usize::from(len), |data| Some(at_zero(Frame::new(id, data)?.with_raw_dlc(raw_dlc))))
        }
        (Identifier::Error(ErrorClass(class)), Length::Classical { len, .. }) => {
            payload(rest, usize::from(len), |data| Frame::error(ErrorClass(class), data).map(at_zero))
        }
        (Identifier::Frame(id), Length::Fd(len)) => {
            payload(rest, len as usize, |data| Record::fd(Timestamp::ZERO, ChannelId(0), id, flags, data))
        }
        (Identifier::Frame(id), Length::Xl(len)) => xl(rest, id.raw(), len as usize),
        _ => Expected::fail(input, "a length that fits the kind of the id"),
    }
}

fn xl(input: &[u8], priority: u32, len: usize) -> Parsed<'_, Body<'_>> {
    let (open, ()) = tag(b"(", "'(' and the CAN XL header")(skip_blanks(input))?;
    let (rest, vcid) = hex_field(2, "two hex digits with the virtual network")(open)?;
    let (rest, flags) = preceded(tag(b"|", "'|'"), hex_field(2, "two hex digits with the flags")).parse(rest)?;
    let (rest, sdt) = preceded(tag(b":", "':'"), hex_field(2, "two hex digits with the payload type")).parse(rest)?;
    let (rest, af) = preceded(tag(b":", "':'"), hex_field(8, "eight hex digits")).parse(rest)?;
    let (rest, ()) = tag(b")", "')'")(rest)?;
    match xl_header(vcid << 12 | priority, flags as u8, sdt as u8, af) {
        Some((id, header)) => payload(rest, len, |data| Record::xl(Timestamp::ZERO, ChannelId(0), id, header, data)),
        None => Expected::fail(open, "CAN XL flags with bit 80 set"),
    }
}

fn at_zero(frame: Frame) -> Record {
    Record::new(Timestamp::ZERO, ChannelId(0), frame)
}

/// Parses `len` bytes and the end of the line.
fn payload(input: &[u8], len: usize, frame: impl Fn(&[u8]) -> Option<Record>) -> Parsed<'_, Body<'_>> {
    let mut data = Vec::with_capacity(len);
    let mut rest = input;
    let (mut bits, mut swapped) = (false, false);
    while data.len() < len {
        let next = match rest {
            [b'`', next @ ..] => next,
            _ => skip_blanks(rest),
        };
        if data.len() == 64 && next.starts_with(b"...") {
            data.resize(len, 0);
            return match frame(&data) {
                Some(record) => Ok((&[], Body { bits, cropped: true, ..Body::new(record) })),
                None => Expected::fail(input, "data"),
            };
        }
        swapped |= matches!(rest, [b'`', ..]);
        let (behind, byte) = match bit_byte(next) {
            Some((behind, byte)) => {
                bits = true;
                (behind, byte)
            }
            None => hex_byte(next)?,
        };
        data.push(byte);
        rest = behind;
    }
    let last = rest;
    if swapped {
        data.reverse();
    }
    let Some(record) = frame(&data) else {
        return Expected::fail(input, "a length that this kind of frame has");
    };
    let text = skip_blanks(last);
    let (rest, behind) = match text {
        [] | [b'\'' | b'`', ..] => (text, Behind::Usual),
        _ => behind(last, text, len)?,
    };
    let is_digits = |byte: u8| byte >> 4 <= 1 && byte & 15 <= 1;
    let doubt = match data[..] {
        _ if !last.is_empty() && !text.is_empty() => Doubt::None,
        [] => Doubt::Remote,
        [byte] if !bits && last.is_empty() && is_digits(byte) => Doubt::Bits,
        _ => Doubt::None,
    };
    Ok((rest, Body { bits, doubt, behind, ..Body::new(record) }))
}

/// Parses a byte written as eight bits.
fn bit_byte(input: &[u8]) -> Option<(&[u8], u8)> {
    let (bits, rest) = input.split_first_chunk::<8>()?;
    let is_bits = bits.iter().all(|b| matches!(b, b'0' | b'1'));
    is_bits.then(|| (rest, bits.iter().fold(0, |byte, bit| byte << 1 | (bit - b'0'))))
}
