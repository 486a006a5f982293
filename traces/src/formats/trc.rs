//! PEAK TRC 1.0 to 2.1: the recordings of PCAN-View and PCAN-Explorer.
//!
//! ```text
//! ;$FILEVERSION=2.1
//! ;$STARTTIME=44548.6028595139
//! ;$COLUMNS=N,O,T,B,I,d,R,L,D
//!       1     17535.400 DT 1  00000100 Tx -  8    00 00 00 00 00 00 00 00
//! ```
//!
//! The version determines the order of the columns:
//!
//! | version | columns |
//! |---|---|
//! | 1.0, which has no `$FILEVERSION` | number, offset, id, DLC, data |
//! | 1.1 | number, offset, direction or kind, id, DLC, data |
//! | 1.2 | number, offset, bus, direction or kind, id, DLC, data |
//! | 1.3 | number, offset, bus, direction or kind, id, reserved, DLC, data |
//! | 2.x | by `$COLUMNS`: N number, O offset, T kind, B bus, I id, d direction, R reserved, L DLC, l length, D data |
//!
//! Pitfalls:
//!
//! - `$STARTTIME` is in days since 1899-12-30 in the recorder's **local** time; 1.0 has it as text in a comment.
//! - Offsets are in milliseconds, with 0, 1 or 3 decimals.
//! - Four id digits are 11 bits, eight are 29; some tools leave out leading zeros of 29-bit ids.
//! - 1.x writes `RTR` in place of the data, and 1.0 `ERROR` before it. A row of 1.0 with id FFFFFFFF, or of kind
//!   `Warng`, is a bus status.
//! - Kinds of 2.x: DT data, RR remote, FD, FB (BRS), FE (ESI), BI (both), ER error frame; ST status, EC error counters,
//!   EV event. Rows of the last four kinds have no id: the column is empty or `-`. A row of another kind is reported.
//! - All rows are numbered, so a missing row is noticed (see [`trc_numbers`](super::trc_numbers)).
//! - L is the DLC, l the length. A classical DLC of 9 to 15 has eight bytes; anything else is malformed.
//!
//! Error frames give no class as Linux has it, and are read as a bus error without detail. A last line without line end
//! is read if it has all bytes that its length promises.

use crate::formats::asc::LATEST;
use crate::formats::candump_log::intern;
use crate::formats::trc_numbers::Numbers;
use crate::formats::trc_row::{Column, Content, columns, message_number, millis, row};
use crate::grammar::{Parsed, billionths, decimal, skip_blanks};
use crate::lines::{Line, LineFormat, TextReader, head_lines};
use crate::{Channels, Damage, DamageKind, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};
use jiff::civil;

pub(crate) use crate::formats::trc_writer::create;

/// Days from 1899-12-30 to 1970-01-01.
pub(crate) const DAYS_TO_1970: u64 = 25_569;
/// Nanoseconds of a day.
pub(crate) const DAY: u64 = 86_400_000_000_000;

const SNIFF_LINES: usize = 100;

pub(crate) fn sniff(head: &[u8]) -> bool {
    head_lines(head).take(SNIFF_LINES).any(|(line, _)| {
        line.starts_with(b";$FILEVERSION=") || line.starts_with(b";$STARTTIME=") || {
            let numbered = number_and_offset(line).is_ok_and(|(_, (_, bracket))| bracket);
            let content = row(line, &Version::V1_0.columns()).map(|(_, row)| row.content);
            numbered && matches!(content, Ok(Content::Frame { .. }))
        }
    })
}

fn number_and_offset(line: &[u8]) -> Parsed<'_, (u64, bool)> {
    let (rest, (_, bracket)) = message_number(skip_blanks(line))?;
    let (rest, offset) = millis(skip_blanks(rest))?;
    Ok((rest, (offset, bracket)))
}

pub(crate) fn open(source: Source, _options: &ReadOptions) -> Box<dyn Reader> {
    let columns = Version::V1_0.columns();
    Box::new(TextReader::new(source, Trc { columns, start: None, start_in_text: None, numbers: Numbers::default() }))
}

struct Trc {
    columns: Vec<Column>,
    /// The start of the recording, in local time.
    start: Option<u64>,
    /// The start from a comment, the only form in version 1.0.
    start_in_text: Option<u64>,
    numbers: Numbers,
}

enum Version {
    V1_0,
    V1_1,
    V1_2,
    V1_3,
    V2_0,
    V2_1,
}

impl Version {
    fn columns(&self) -> Vec<Column> {
        use Column::{Bus, Data, Direction, Dlc, Id, Kind, Length, Number, Offset, Reserved};
        let direction = Column::DirectionOrKind;
        match self {
            Self::V1_0 => vec![Number, Offset, Id, Dlc, Data],
            Self::V1_1 => vec![Number, Offset, direction, Id, Dlc, Data],
            Self::V1_2 => vec![Number, Offset, Bus, direction, Id, Dlc, Data],
            Self::V1_3 => vec![Number, Offset, Bus, direction, Id, Reserved, Dlc, Data],
            Self::V2_0 => vec![Number, Offset, Kind, Id, Direction, Length, Data],
            Self::V2_1 => vec![Number, Offset, Kind, Bus, Id, Direction, Reserved, Dlc, Data],
        }
    }
}

impl LineFormat for Trc {
    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        match skip_blanks(line.bytes) {
            [] => None,
            [b';', comment @ ..] => self.comment(line, comment).map(Err),
            _ => self.row(line, channels).transpose(),
        }
    }

    fn owed(&mut self) -> Option<Damage> {
        self.numbers.owed()
    }

    fn end(&mut self) -> Option<Damage> {
        self.numbers.end()
    }

    fn time_base(&self) -> TimeBase {
        if self.start().is_some() { TimeBase::Local } else { TimeBase::Start }
    }
}

impl Trc {
    fn start(&self) -> Option<u64> {
        self.start.or(self.start_in_text)
    }

    fn comment(&mut self, line: &Line<'_>, comment: &[u8]) -> Option<Damage> {
        let unsupported = |expected| Some(line.as_damage(DamageKind::Unsupported, expected));
        if let Some(version) = comment.strip_prefix(b"$FILEVERSION=") {
            let version = match version.trim_ascii() {
                b"1.0" => Version::V1_0,
                b"1.1" => Version::V1_1,
                b"1.2" => Version::V1_2,
                b"1.3" => Version::V1_3,
                b"2.0" => Version::V2_0,
                b"2.1" => Version::V2_1,
                _ => return unsupported("a version of 1.0 to 2.1"),
            };
            self.columns = version.columns();
        } else if let Some(days) = comment.strip_prefix(b"$STARTTIME=") {
            self.start = start_time(days.trim_ascii());
            self.numbers.restart();
            if self.start.is_none() {
                return unsupported("days since 1899-12-30, such as 44548.6028595139");
            }
        } else if let Some(letters) = comment.strip_prefix(b"$COLUMNS=") {
            match columns(letters) {
                Some(columns) => self.columns = columns,
                None => return unsupported("columns out of N, O, T, B, I, d, R, L, l, D"),
            }
        } else if let Some(text) = skip_blanks(comment).strip_prefix(b"Start time:") {
            self.start_in_text = start_in_text(text.trim_ascii());
        } else if [comment, &[b"0", comment].concat()].iter().any(|text| self.is_row(text)) {
            // The damaged first byte was a space, or a digit of the row's number.
            self.numbers.pass();
            return Some(line.malformed("a row, or a comment without a row"));
        }
        None
    }

    /// Whether the text is a row of a known kind. The table of buses in a header has rows that begin with numbers, too.
    fn is_row(&self, text: &[u8]) -> bool {
        row(text, &self.columns).is_ok_and(|(_, row)| !matches!(row.content, Content::Unsupported))
    }

    fn row(&mut self, line: &Line<'_>, channels: &mut Channels) -> Result<Option<Record>, Damage> {
        let row = row(line.bytes, &self.columns).map(|(_, row)| row);
        match row.as_ref().map(|row| row.number) {
            Ok(Some(number)) => self.numbers.see(number, line.place),
            // A malformed row has a number too.
            _ => self.numbers.pass(),
        }
        match row.map_err(|error| line.damage(error.into()))?.content {
            // The kind of a cut row is unknown.
            Content::Event | Content::Unsupported if !line.ended => Err(line.cut("the end of this row")),
            Content::Event => Ok(None),
            Content::Unsupported => Err(line.as_damage(DamageKind::Unsupported, "a kind of row of TRC 1.0 to 2.1")),
            Content::Frame { in_doubt: true, .. } if !line.ended => {
                Err(line.cut("the end of this line, as the frame may go on,"))
            }
            Content::Frame { offset, bus, mut record, .. } => {
                record.channel = intern(bus, channels).map_err(|missing| line.damage(missing))?;
                let time = Timestamp(offset).after(self.start().unwrap_or(0));
                record.timestamp = time.ok_or_else(|| line.malformed(LATEST))?;
                record.place = line.place;
                Ok(Some(record))
            }
        }
    }
}

/// Parses a start in days since 1899-12-30; gives nanoseconds since 1970.
fn start_time(days: &[u8]) -> Option<u64> {
    let (rest, whole) = decimal("days")(days).ok()?;
    let fraction = match rest {
        [] => 0,
        [b'.', digits @ ..] if !digits.is_empty() && digits.iter().all(u8::is_ascii_digit) => {
            // 18 digits are far more precise than nanoseconds.
            let digits = digits.get(..18).unwrap_or(digits);
            let scale = 10_u128.pow(digits.len() as u32);
            let value = digits.iter().fold(0, |value, digit| 10 * value + u128::from(digit - b'0'));
            u64::try_from((value * u128::from(DAY) + scale / 2) / scale).ok()?
        }
        _ => return None,
    };
    whole.checked_sub(DAYS_TO_1970)?.checked_mul(DAY)?.checked_add(fraction)
}

/// Parses a start such as `18.12.2021 14:28:07.062`; more digits may follow after another point.
fn start_in_text(text: &[u8]) -> Option<u64> {
    let text = std::str::from_utf8(text).ok()?;
    let (date, time) = text.split_once(' ')?;
    let mut date = date.splitn(3, '.');
    let (day, month, year) = (date.next()?.parse().ok()?, date.next()?.parse().ok()?, date.next()?.parse().ok()?);
    let mut time = time.trim().splitn(3, ':');
    let (hour, minute, second) = (time.next()?.parse().ok()?, time.next()?.parse().ok()?, time.next()?);
    let mut second = second.split('.');
    let whole = second.next()?.parse().ok()?;
    let fraction = second.next().map_or(Ok((&[][..], 0)), |digits| billionths(digits.as_bytes())).ok()?.1;
    let time = civil::Time::new(hour, minute, whole, i32::try_from(fraction).ok()?).ok()?;
    crate::local_time::nanos(civil::Date::new(year, month, day).ok()?.to_datetime(time))
}
