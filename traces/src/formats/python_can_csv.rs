//! python-can's CSV.
//!
//! ```text
//! timestamp,arbitration_id,extended,remote,error,dlc,data
//! 1700000000.123456,0x63f,0,0,0,8,QABgAAAAAAA=
//! ```
//!
//! - Times are Python's shortest decimal form of a double: they have any number of digits, and may have an exponent.
//!   They count from 1970 or, if below 1973, from the start.
//! - `dlc` is the length in bytes, the data is Base64. More than 8 bytes are CAN FD; **the file does not distinguish
//!   CAN FD frames of up to 8 bytes from classical ones**, and lacks BRS and ESI.
//! - The file has no channel and no direction; all frames are on one channel, named `1`.
//!
//! A last line without line end is read if its data has the length in `dlc`.

use crate::formats::python_can::{CHANNEL, Message, Wrong, time_base};
use crate::grammar::{Expected, Parsed, decimal, hex_run, tag};
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::text_writer::{LineWriter, TextWriter};
use crate::{
    Channels, Damage, Direction, Flags, Loss, Losses, ReadOptions, Reader, Record, Source, TimeBase, WriteError,
    WriteOptions, Writer,
};
use std::fmt::Write as _;
use std::io::Write;

const HEADER: &str = "timestamp,arbitration_id,extended,remote,error,dlc,data";

pub(crate) fn sniff(head: &[u8]) -> bool {
    let line = head_lines(head).map(|(line, _)| line.trim_ascii()).find(|line| !line.is_empty());
    line.is_some_and(|line| line.starts_with(HEADER.as_bytes()))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(TextReader::new(source, Csv { base: None }))
}

struct Csv {
    base: Option<TimeBase>,
}

impl LineFormat for Csv {
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        let text = line.bytes.trim_ascii();
        if text.is_empty() || text.starts_with(HEADER.as_bytes()) {
            return None;
        }
        Some(match row(line.bytes) {
            Ok((_, mut record)) => {
                self.base.get_or_insert(time_base(record.timestamp));
                record.channel = channels.intern(CHANNEL);
                record.place = line.place;
                Ok(record)
            }
            Err(error) => Err(line.damage(error.into())),
        })
    }

    fn time_base(&self) -> TimeBase {
        self.base.unwrap_or_default()
    }
}

fn row(input: &[u8]) -> Parsed<'_, Record> {
    let (rest, nanos) = time(input)?;
    let (at, ()) = comma(rest)?;
    let (rest, ()) = tag(b"0x", "an id such as 0x63f")(at)?;
    let (rest, digits, id) = hex_run(rest);
    let (rest, ()) = comma(rest)?;
    let (rest, extended) = switch(rest)?;
    let (rest, ()) = comma(rest)?;
    let (rest, remote) = switch(rest)?;
    let (rest, ()) = comma(rest)?;
    let (rest, error) = switch(rest)?;
    let (rest, ()) = comma(rest)?;
    let (len_at, len) = decimal("a length")(rest)?;
    let (data_at, ()) = comma(len_at)?;
    let (rest, data) = base64(data_at)?;
    let message = Message { nanos, id, extended, remote, error, length: len, data: &data };
    match message.record() {
        _ if digits == 0 => Expected::fail(at, ID),
        Ok(record) => Ok((rest, record)),
        Err(Wrong::Id) => Expected::fail(at, ID),
        Err(Wrong::Missing) => Expected::fail(rest, Wrong::Missing.expected()),
        Err(wrong) => Expected::fail(data_at, wrong.expected()),
    }
}

const ID: &str = Wrong::Id.expected();

fn comma(input: &[u8]) -> Parsed<'_, ()> {
    tag(b",", "a comma")(input)
}

fn switch(input: &[u8]) -> Parsed<'_, bool> {
    match input {
        [b'0', rest @ ..] => Ok((rest, false)),
        [b'1', rest @ ..] => Ok((rest, true)),
        _ => Expected::fail(input, "0 or 1"),
    }
}

/// Parses seconds as Python writes a double; gives nanoseconds, rounded.
fn time(input: &[u8]) -> Parsed<'_, u64> {
    const WHAT: &str = "a time in seconds";
    let len = input.iter().take_while(|b| b.is_ascii_digit() || b".eE+-".contains(b)).count();
    let (number, rest) = input.split_at_checked(len).unwrap_or((input, &[]));
    let Ok((behind, whole)) = decimal(WHAT)(number) else { return Expected::fail(input, WHAT) };
    let nanos = match behind {
        [] => whole.checked_mul(1_000_000_000),
        [b'.', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) => {
            // A double would not be exact, so the decimal digits are read: nine of them, rounded by the tenth.
            let digit = |n: usize| digits.get(n).map_or(0, |d| u64::from(d - b'0'));
            let fraction = (0..9).fold(0, |value, n| 10 * value + digit(n)) + digit(9) / 5;
            whole.checked_mul(1_000_000_000).and_then(|nanos| nanos.checked_add(fraction))
        }
        _ => std::str::from_utf8(number).ok().and_then(|text| text.parse::<f64>().ok()).and_then(|seconds| {
            let nanos = (seconds * 1e9).round();
            (0.0..=u64::MAX as f64).contains(&nanos).then_some(nanos as u64)
        }),
    };
    nanos.map_or_else(|| Expected::fail(input, WHAT), |nanos| Ok((rest, nanos)))
}

const BASE64: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Parses Base64 with padding (RFC 4648) up to the end of the line; at most the 64 bytes of CAN FD.
fn base64(input: &[u8]) -> Parsed<'_, Vec<u8>> {
    let mut data = Vec::new();
    let mut rest = input.trim_ascii_end();
    while let Some((group, behind)) = rest.split_first_chunk::<4>() {
        let padding = group.iter().rev().take_while(|&&b| b == b'=').count();
        let mut bits = 0_u32;
        for byte in group.iter().take(4 - padding) {
            let Some(value) = BASE64.iter().position(|b| b == byte) else { return Expected::fail(rest, "Base64") };
            bits = bits << 6 | value as u32;
        }
        if padding > 2 || (padding > 0 && !behind.is_empty()) || data.len() >= 64 {
            return Expected::fail(rest, "Base64 of at most 64 bytes");
        }
        let [_, a, b, c] = (bits << (6 * padding)).to_be_bytes();
        data.extend_from_slice([a, b, c].get(..3 - padding).unwrap_or_default());
        rest = behind;
    }
    match rest {
        [] => Ok((&input[input.len()..], data)),
        // The error is at the end, where characters are missing.
        _ => Expected::fail(&input[input.len()..], "the rest of a group of four Base64 letters"),
    }
}

fn write_base64(out: &mut String, data: &[u8]) {
    for group in data.chunks(3) {
        let byte = |n: usize| group.get(n).map_or(0, |&b| u32::from(b));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for n in 0..4 {
            let letter = BASE64[(bits >> (18 - 6 * n) & 63) as usize];
            out.push(if n <= group.len() { char::from(letter) } else { '=' });
        }
    }
}

pub(crate) fn create(sink: Box<dyn Write>, options: &WriteOptions) -> Result<Box<dyn Writer>, WriteError> {
    Ok(Box::new(TextWriter::new(sink, CsvRows { time_base: options.time_base })))
}

struct CsvRows {
    time_base: TimeBase,
}

impl LineWriter for CsvRows {
    const COMMENT: Option<(&'static str, &'static str)> = None;

    fn header(&mut self, _first: Option<&Record>, out: &mut String) {
        out.push_str(HEADER);
        out.push('\n');
    }

    fn record(&mut self, record: &Record, channel: &str, out: &mut String, losses: &mut Losses) {
        let frame = &record.frame;
        if frame.is_xl() {
            losses.count(Loss::Frame);
            return;
        }
        self.count_losses(record, channel, losses);
        let nanos = record.timestamp.nanos();
        let (secs, fraction) = (nanos / 1_000_000_000, nanos % 1_000_000_000);
        // Writing into a String does not fail.
        let _ = if fraction.is_multiple_of(1_000) {
            write!(out, "{secs}.{:06}", fraction / 1_000)
        } else {
            write!(out, "{secs}.{fraction:09}")
        };
        let flag = u8::from;
        let extended = flag(frame.id().is_extended());
        let _ = write!(out, ",{:#x},{extended},{}", frame.id().raw(), flag(frame.is_remote()));
        let _ = write!(out, ",{},{},", flag(frame.is_error()), frame.len());
        write_base64(out, record.data());
        out.push('\n');
    }
}

impl CsvRows {
    fn count_losses(&self, record: &Record, channel: &str, losses: &mut Losses) {
        let frame = &record.frame;
        let flags = frame.flags();
        let lost = [
            (self.time_base == TimeBase::Local, Loss::TimeZone),
            (channel != CHANNEL, Loss::ChannelName),
            (record.direction != Direction::Unknown, Loss::Direction),
            // Only the length shows that a frame is CAN FD: for a short frame, this fact is lost too.
            (flags.bits() & 3 != 0 || frame.is_fd() && frame.len() <= 8, Loss::FdFlags),
            (flags == Flags::NONE && frame.dlc() > 8, Loss::RawDlc),
        ];
        lost.into_iter().filter(|(is_lost, _)| *is_lost).for_each(|(_, loss)| losses.count(loss));
    }
}
