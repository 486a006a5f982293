//! The log of candump: `candump -l`, `-f` and `-L` write it, and `canplayer` reads it.
//!
//! ```text
//! line = "(" SECONDS "." FRACTION ")" IFACE FRAME [" R" | " T"] [token]
//! ```
//!
//! FRAME is described in [`crate::notation`]. Pitfalls:
//!
//! - The fraction has 6 or 9 digits. Times count from 1970, or with `-tz` from the first frame; the reader assumes
//!   `-tz` for a log that begins before 1973.
//! - The interface name is padded on its left to the longest name so far, so several spaces are normal.
//! - `R` or `T` is the direction (`-x`). Another single word after the frame is ignored, unless it is two hex digits:
//!   then the bytes were written apart, and ignoring them would invent a shorter frame.
//! - `DROPCOUNT: dropped N CAN frames on …` means that the recorder lost frames; it becomes
//!   [`crate::DamageKind::Dropped`]. Lines that begin with a tab after an error frame are its explanation (`-e`).
//! - Comments (`#`, `//`, `;`), blank lines, CRLF and a byte order mark come from editors. A line that would be a frame
//!   with another first byte is no comment, but a damaged frame.
//!
//! # The last line without line end
//!
//! candump ends every line. A last line without line end was cut or comes from an editor, and `123#11` may be the
//! beginning of `123#1122`. Such a line is read only if its frame can't continue: it has all 8 data bytes (64 for CAN
//! FD), a remote frame's length, a raw DLC, or a direction after it. If the lines before it had a direction, it needs a
//! direction, too; if they had a raw DLC, 8 bytes alone are not enough. Otherwise it is reported as truncated: a
//! reported loss is better than an invented frame.

use crate::formats::candump_usual::{self, Names};
use crate::grammar::{Expected, Parsed, blanks1, decimal, seconds, skip_blanks, tag, word};
use crate::lines::{Line, LineFormat, Passed, TextReader, head_lines};
use crate::notation::{frame, write_frame};
use crate::text_writer::{LineWriter, TextWriter};
use crate::{
    ChannelId, Channels, Damage, Direction, Flags, Frame, Loss, Losses, Place, ReadOptions, Reader, Record, SkipSet,
    Source, TimeBase, Timestamp, WriteError, WriteOptions, Writer,
};
use std::fmt::Write as _;
use std::io::Write;

/// A log that begins before this time (1973) counts from its own start.
pub(crate) const EPOCH_FROM: u64 = 100_000_000 * 1_000_000_000;

/// Maximum number of lines without frame before the first frame.
const SNIFF_LINES: usize = 200;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head_lines(head).take(SNIFF_LINES).any(|(line, _)| looks_like_log(line))
}

/// Whether the line looks like `(1.5) can0 123#`. The id is not checked, so that a log with a damaged first line is
/// recognised.
fn looks_like_log(line: &[u8]) -> bool {
    let Ok((rest, _)) = stamp_and_interface(line) else { return false };
    word("frame")(rest).is_ok_and(|(_, word)| matches!(word.iter().position(|&b| b == b'#'), Some(1..=8)))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(TextReader::new(source, CandumpLog::default()))
}

#[derive(Default)]
struct CandumpLog {
    base: Option<TimeBase>,
    /// Whether the last frame was an error frame: candump may print an explanation after an error frame.
    explained: bool,
    habits: Habits,
    /// The names that the quick parser knows; empty until the first frame was read.
    names: Names,
}

/// The parts of the frames so far that follow the data: a last line without end must have them too.
#[derive(Default)]
struct Habits {
    direction: bool,
    raw_dlc: bool,
}

impl LineFormat for CandumpLog {
    #[inline]
    fn usual_line(&mut self, window: &[u8], place: Place) -> Option<(Record, usize)> {
        let usual = candump_usual::line(window, &self.names, place)?;
        self.explained = false;
        self.habits.direction |= usual.0.direction != Direction::Unknown;
        Some(usual)
    }

    #[inline]
    fn pass_line(&mut self, window: &[u8], skip: &SkipSet, place: Place) -> Option<Passed> {
        let (direction, passed) = candump_usual::pass(window, &self.names, skip, place)?;
        self.explained = false;
        self.habits.direction |= direction != Direction::Unknown;
        Some(passed)
    }

    fn skipped_time(&self, window: &[u8]) -> Option<Timestamp> {
        candump_usual::time_of(window)
    }

    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        match line.bytes {
            [b'(', ..] => {}
            other => return self.other_line(line, skip_blanks(other), channels),
        }
        Some(self.frame_line(line, line.bytes, channels))
    }

    fn time_base(&self) -> TimeBase {
        self.base.unwrap_or_default()
    }
}

impl CandumpLog {
    #[inline]
    fn frame_line(&mut self, line: &Line<'_>, text: &[u8], channels: &mut Channels) -> Result<Record, Damage> {
        let damage = |error| line.damage(Expected::from(error));
        let (rest, (nanos, name)) = stamp_and_interface(text).map_err(damage)?;
        let (after, record) = frame(rest).map_err(damage)?;
        let tail = tail(after).map_err(|missing| line.damage(missing))?;
        if !line.ended && !self.habits.complete(&record.frame, &tail) {
            return Err(line.cut("the end of this line, as the frame may go on,"));
        }
        let channel = intern(name, channels).map_err(|missing| line.damage(missing))?;
        self.names.learn(text, rest, channel);
        self.base.get_or_insert(if nanos < EPOCH_FROM { TimeBase::Start } else { TimeBase::Utc });
        self.explained = record.frame.is_error();
        self.habits.learn(&record.frame, tail.direction);
        Ok(record.seen(Timestamp(nanos), channel, tail.direction, line.place))
    }

    /// Parses a line that is no frame, or a frame after spaces.
    fn other_line(&mut self, line: &Line<'_>, text: &[u8], channels: &mut Channels) -> Option<Result<Record, Damage>> {
        if let [b'(', ..] = text {
            return Some(self.frame_line(line, text, channels));
        }
        match aside(line, self.explained, is_frame) {
            Some(damage) => damage.map(Err),
            None => Some(Err(line.damage(Expected::new(text, "a frame, such as (1700000000.123456) can0 123#11")))),
        }
    }
}

/// Whether the bytes after the first one of a line are those of a frame.
fn is_frame(after: &[u8]) -> bool {
    let line = [b"(", after].concat();
    stamp_and_interface(&line).is_ok_and(|(rest, _)| frame(rest).is_ok())
}

/// Recognises a line without frame, of candump or from an editor, and returns the loss that it reports. `explained`:
/// the frame before the line was an error frame. `is_frame`: whether the line without its first byte, which may be
/// damaged, holds a frame.
pub(crate) fn aside(line: &Line<'_>, explained: bool, is_frame: impl FnOnce(&[u8]) -> bool) -> Option<Option<Damage>> {
    let text = skip_blanks(line.bytes);
    let passed_over = match text {
        [] => return Some(None),
        [b'#' | b';', ..] | [b'/', b'/', ..] => true,
        // A terminal's prompt and interrupt, and the marks around code in Markdown.
        [b'$', b' ', ..] | [b'`', b'`', b'`', ..] | [b'^', b'C'] => true,
        _ => explained && line.bytes.first() == Some(&b'\t'),
    };
    if passed_over {
        let frame = line.bytes.split_first().is_some_and(|(_, after)| is_frame(after));
        return Some(frame.then(|| line.malformed("a frame, or a comment without a frame")));
    }
    let (_, count) = drop_count(text).ok()?;
    Some(Some(Damage::dropped(count, line.place)))
}

/// Limit of an interface name: far longer than Linux allows, yet 4096 of them take little memory.
const LONGEST_NAME: usize = 128;

/// The channel with that name.
pub(crate) fn intern<'a>(name: &'a [u8], channels: &mut Channels) -> Result<ChannelId, Expected<'a>> {
    match std::str::from_utf8(name) {
        Ok(name) if name.len() <= LONGEST_NAME => Ok(channels.intern(name)),
        _ => Err(Expected::new(name, "an interface name of at most 128 bytes in UTF-8")),
    }
}

/// Parses time and interface, and the spaces after them.
#[inline]
fn stamp_and_interface(input: &[u8]) -> Parsed<'_, (u64, &[u8])> {
    let (rest, ()) = tag(b"(", "'('")(skip_blanks(input))?;
    let (rest, nanos) = seconds(rest)?;
    let (rest, ()) = tag(b")", "')' after the time")(rest)?;
    let (rest, ()) = blanks1(rest)?;
    let (rest, name) = word("an interface name")(rest)?;
    let (rest, ()) = blanks1(rest)?;
    Ok((rest, (nanos, name)))
}

/// Parses `DROPCOUNT: dropped 5 CAN frames on 'can0' socket (total drops 7)`.
///
/// candump prints the number with a sign, so a number from 2^31 on is negative.
fn drop_count(input: &[u8]) -> Parsed<'_, u64> {
    let (rest, ()) = tag(b"DROPCOUNT: dropped ", "DROPCOUNT")(input)?;
    match rest {
        [b'-', rest @ ..] => {
            decimal("a number of frames")(rest).map(|(rest, n)| (rest, (1_u64 << 32).saturating_sub(n)))
        }
        _ => decimal("a number of frames")(rest),
    }
}

/// The text after a frame.
struct Tail {
    direction: Direction,
    /// Whether a word has ended the frame.
    closed: bool,
    /// Whether the text ends in a space, which a word may follow.
    open: bool,
}

#[inline]
fn tail(input: &[u8]) -> Result<Tail, Expected<'_>> {
    if input.is_empty() {
        return Ok(Tail { direction: Direction::Unknown, closed: false, open: false });
    }
    let none = Tail { direction: Direction::Unknown, closed: false, open: !input.is_empty() };
    let mut rest = skip_blanks(input);
    if rest.is_empty() {
        return Ok(none);
    }
    if rest.len() == input.len() {
        return Err(Expected::new(input, "a hex digit of the data or the end of the frame"));
    }
    let direction = match rest {
        [b'R', ..] => Direction::Rx,
        [b'T', ..] => Direction::Tx,
        _ => Direction::Unknown,
    };
    if let [b'R' | b'T'] | [b'R' | b'T', b' ' | b'\t', ..] = rest {
        rest = skip_blanks(&rest[1..]);
        ignore(rest)?;
        return Ok(Tail { direction, closed: true, open: false });
    }
    ignore(rest)?;
    Ok(Tail { closed: true, open: false, ..none })
}

/// Parses a single word, or a comment, which is ignored.
fn ignore(input: &[u8]) -> Result<(), Expected<'_>> {
    let Ok((rest, token)) = word("a word")(input) else { return Ok(()) };
    let is_comment = matches!(token, [b'#' | b';', ..] | [b'/', b'/', ..]);
    let is_byte = matches!(token, [high, low] if high.is_ascii_hexdigit() && low.is_ascii_hexdigit());
    if is_byte || (!is_comment && !skip_blanks(rest).is_empty()) {
        return Err(Expected::new(input, "the end of the line, 'R' or 'T' after the frame"));
    }
    Ok(())
}

impl Habits {
    #[inline]
    fn learn(&mut self, frame: &Frame, direction: Direction) {
        self.direction |= direction != Direction::Unknown;
        self.raw_dlc |= frame.flags() == Flags::NONE && frame.dlc() > 8;
    }

    /// Whether a line without end can't be the beginning of a longer one.
    fn complete(&self, frame: &Frame, tail: &Tail) -> bool {
        if tail.closed {
            return !self.direction || tail.direction != Direction::Unknown;
        }
        if tail.open || self.direction {
            return false;
        }
        let longest = match () {
            () if frame.is_xl() => 2048,
            () if frame.is_fd() => 64,
            () if frame.is_remote() => return (1..8).contains(&frame.len()) || frame.len() == 8 && !self.raw_dlc,
            () if frame.is_error() || frame.dlc() > 8 || !self.raw_dlc => 8,
            () => return false,
        };
        frame.len() == longest
    }
}

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    Ok(Box::new(TextWriter::new(sink, LogLines { time_base: options.time_base })))
}

/// Writes lines like `candump -L`, with the direction if it is known (`-x`).
struct LogLines {
    time_base: TimeBase,
}

impl LineWriter for LogLines {
    const COMMENT: Option<(&'static str, &'static str)> = Some(("# ", "\n"));

    fn record(&mut self, record: &Record, channel: &str, out: &mut String, losses: &mut Losses) {
        if self.time_base == TimeBase::Local {
            losses.count(Loss::TimeZone);
        }
        // Writing into a String does not fail.
        let _ = self.write_line(record, &interface_name(channel, losses), out);
    }
}

impl LogLines {
    fn write_line(&self, record: &Record, name: &str, out: &mut String) -> std::fmt::Result {
        let nanos = record.timestamp.nanos();
        let (secs, fraction) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
        // Times since 1970 have ten digits; candump -tz writes at least three.
        write!(out, "({secs:03}.")?;
        if fraction.is_multiple_of(1_000) {
            write!(out, "{:06}) {name} ", fraction / 1_000)?;
        } else {
            write!(out, "{fraction:09}) {name} ")?;
        }
        write_frame(out, &record.frame, record.xl_header(), record.data())?;
        out.write_str(match record.direction {
            Direction::Unknown => "\n",
            Direction::Rx => " R\n",
            Direction::Tx => " T\n",
        })
    }
}

/// The name as one word; logs can't hold spaces in names.
fn interface_name<'a>(name: &'a str, losses: &mut Losses) -> std::borrow::Cow<'a, str> {
    let unfit = |c: char| c.is_whitespace() || c.is_control();
    if !name.is_empty() && name.len() <= LONGEST_NAME && !name.contains(unfit) {
        return name.into();
    }
    losses.count(Loss::ChannelName);
    let mut fit: String = name.chars().map(|c| if unfit(c) { '_' } else { c }).collect();
    while fit.len() > LONGEST_NAME {
        fit.pop();
    }
    if fit.is_empty() { "can0".into() } else { fit.into() }
}
