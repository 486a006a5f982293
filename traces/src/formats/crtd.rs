//! CRTD: the log of the Open Vehicle Monitoring System, which SavvyCAN reads and writes too.
//!
//! ```text
//! 1542473901.020305 CXX Info Type:crtd; Filter:off;
//! 1542473901.020305 1R11 7ED 04 41 0C 00 00 AA AA AA
//! 1542473901.031 2T29 18FF1234 01 02
//! ```
//!
//! - Times are seconds since 1970, or since the start of the recorder, with three or six decimals.
//! - `R` is received, `T` sent; 11 or 29 are the bits of the identifier. The number of the bus before that may be absent.
//! - Records whose type begins with `C` are comments, events and statistics; they hold no frames.
//! - The format has no remote frames and no errors of the bus as frames.
//!
//! Nothing marks the end of the data: a last line without line end is whole only if it has eight bytes.

use crate::grammar::{Expected, Parsed, billionths, blanks1, decimal, hex_byte, hexadecimal, skip_blanks, tag};
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::{CanId, Channels, Damage, Direction, Frame, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};

const SECOND: u64 = 1_000_000_000;
/// Times from this second on, in 2001, are dates: no recorder runs that long.
const FIRST_DATE: u64 = 1_000_000_000;
/// The bus of a record without a number.
const USUAL_BUS: u8 = b'1';
const SNIFF_LINES: usize = 20;

pub(crate) fn sniff(head: &[u8]) -> bool {
    let mut lines = head_lines(head).take(SNIFF_LINES).map(|(line, _)| line.trim_ascii());
    lines.any(|line| record(line).is_ok_and(|(_, record)| record.is_some() || is_comment(line)))
}

/// Whether the record is a comment, with which logs begin. Other types without a frame are no sign of this format: `CAN`
/// is a word of many tools.
fn is_comment(line: &[u8]) -> bool {
    line.split(|byte| *byte == b' ').nth(1).is_some_and(|kind| kind.ends_with(b"CXX"))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    Box::new(TextReader::new(source, Crtd::default()))
}

#[derive(Default)]
struct Crtd {
    /// Whether the times are dates; `None` before the first record.
    has_dates: Option<bool>,
}

impl LineFormat for Crtd {
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        let text = line.bytes.trim_ascii_end();
        if text.is_empty() {
            return None;
        }
        let (rest, frame) = match record(text) {
            Ok((rest, frame)) => (rest, frame?),
            Err(error) => return Some(Err(line.damage(error.into()))),
        };
        if !rest.is_empty() {
            return Some(Err(line.damage(Expected::new(rest, "at most 8 bytes, each after one space"))));
        }
        if !line.ended && frame.frame.len() < 8 {
            return Some(Err(line.cut("the end of this line, as the frame may go on,")));
        }
        self.has_dates.get_or_insert(frame.time.nanos() >= FIRST_DATE * SECOND);
        let channel = channels.intern(char::from(frame.bus).encode_utf8(&mut [0; 4]));
        let mut record = Record::new(frame.time, channel, frame.frame);
        (record.direction, record.place) = (frame.direction, line.place);
        Some(Ok(record))
    }

    fn time_base(&self) -> TimeBase {
        if self.has_dates == Some(false) { TimeBase::Start } else { TimeBase::Utc }
    }
}

struct CrtdFrame {
    time: Timestamp,
    bus: u8,
    direction: Direction,
    frame: Frame,
}

/// Parses a record; `None` for one that holds no frame.
fn record(input: &[u8]) -> Parsed<'_, Option<CrtdFrame>> {
    let (rest, time) = time(input)?;
    let (rest, ()) = blanks1(rest)?;
    let (rest, bus) = match rest {
        [bus @ b'1'..=b'9', rest @ ..] => (rest, *bus),
        _ => (rest, USUAL_BUS),
    };
    if let [b'C', b'A'..=b'Z', b'A'..=b'Z', rest @ ..] = rest {
        return if matches!(rest, [] | [b' ', ..]) { Ok((&[], None)) } else { Expected::fail(rest, "a space") };
    }
    let (direction, bits) = match rest {
        [b'R', bits @ ..] => (Direction::Rx, bits),
        [b'T', bits @ ..] => (Direction::Tx, bits),
        _ => return Expected::fail(rest, "a type such as 1R11, T29 or CXX"),
    };
    let (rest, is_extended) = match bits {
        [b'1', b'1', rest @ ..] => (rest, false),
        [b'2', b'9', rest @ ..] => (rest, true),
        _ => return Expected::fail(bits, "11 or 29"),
    };
    let (id_text, ()) = blanks1(rest)?;
    let (rest, raw) = hexadecimal("an id in hex")(id_text)?;
    let id = if is_extended { CanId::extended(raw) } else { CanId::standard(raw) };
    let Some(id) = id else { return Expected::fail(id_text, "an id of at most 7FF (11) or 1FFFFFFF (29)") };
    let (rest, frame) = data(rest, id)?;
    Ok((rest, Some(CrtdFrame { time, bus, direction, frame })))
}

fn time(input: &[u8]) -> Parsed<'_, Timestamp> {
    let (rest, seconds) = decimal("a time in seconds")(input)?;
    let (rest, ()) = tag(b".", "a point after the seconds")(rest)?;
    let (rest, nanos) = billionths(rest)?;
    match seconds.checked_mul(SECOND).and_then(|whole| whole.checked_add(u64::from(nanos))) {
        Some(time) => Ok((rest, Timestamp(time))),
        None => Expected::fail(input, "a time before the year 2554"),
    }
}

fn data(mut input: &[u8], id: CanId) -> Parsed<'_, Frame> {
    let (mut bytes, mut count) = ([0; 8], 0);
    while let Some(place) = bytes.get_mut(count) {
        let text = skip_blanks(input);
        if text.is_empty() || text.len() == input.len() {
            break;
        }
        (input, *place) = hex_byte(text)?;
        count += 1;
    }
    match Frame::new(id, bytes.get(..count).unwrap_or_default()) {
        Some(frame) => Ok((input, frame)),
        None => Expected::fail(input, "at most 8 bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Capture, Format};

    fn read(text: &str) -> (Vec<String>, TimeBase) {
        let options = ReadOptions { format: Some(Format::Crtd), ..ReadOptions::default() };
        let mut capture = Capture::from_source("test", Source::from_bytes(text.as_bytes()), &options).unwrap();
        let shown = |record: Record, channels: &Channels| {
            let channel = channels.name(record.channel);
            format!("{} {channel} {:?} {}", record.timestamp, record.direction, record.frame)
        };
        let mut lines = Vec::new();
        while let Some(item) = capture.next() {
            lines.push(match item {
                Ok(record) => shown(record, capture.channels()),
                Err(damage) => damage.to_string(),
            });
        }
        (lines, capture.time_base())
    }

    /// The lines of a log of OVMS, and the examples in its documentation of the format.
    #[test]
    fn records_of_the_recorder() {
        let log = "100.602 CXX Info Type:crtd; Path:'/sd/drive.crtd'; Filter:off;\n101.562 1T11 7DF 02 01 0C 00 00 00 00 00\n\
                   134.562 1R11 7ED 04 41 0C 00 00 AA AA AA\n211.572 CEV Event vehicle.on\n";
        let (lines, base) = read(log);
        assert_eq!(base, TimeBase::Start);
        assert_eq!(lines.len(), 2, "{lines:?}");
        assert!(lines[0].ends_with("1 Tx 7DF#02010C0000000000"), "{lines:?}");
        assert!(lines[1].contains("134.562") && lines[1].ends_with("1 Rx 7ED#04410C0000AAAAAA"), "{lines:?}");
        let (lines, base) = read("1542473901.020305 2R29 18FF1234 01 02\n1542473901.021 R11 705 05\r\n");
        assert_eq!(base, TimeBase::Utc);
        assert!(lines[0].ends_with("2 Rx 18FF1234#0102") && lines[1].ends_with("1 Rx 705#05"), "{lines:?}");
    }

    #[test]
    fn mistakes_are_told() {
        for (wrong, told) in [
            ("1.0 R11 800 00\n", "at most 7FF"),
            ("1.0 R12 700 00\n", "11 or 29"),
            ("1.0 X11 700 00\n", "a type such as"),
            ("1.0 R11 700 00 01 02 03 04 05 06 07 08\n", "at most 8 bytes"),
            ("1.0 R11 700 0001\n", "at most 8 bytes, each after one space"),
            ("1 R11 700 00\n", "a point"),
            ("1.0 R11 700 00", "may go on"),
        ] {
            let (lines, _) = read(wrong);
            assert!(lines.len() == 1 && lines[0].contains(told), "{wrong}: {lines:?}");
        }
    }
}
