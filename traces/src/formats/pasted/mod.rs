//! Lines that hold frames in no known format: pasted text, and what windows of tools show.
//!
//! ```text
//! line     = [quote mark] [number of the line] before identifier [flags] [length] data behind [remark]
//! before   = time, date, channel, direction, labels such as `ID:`, words that other lines have too; in any order
//! identifier = `605`, `0x605`, `605h`; `18FF1234x` or eight digits for 29 bits
//! length   = `8`, `[8]`, `DLC: 8`
//! data     = bytes apart, together, with `0x`, with commas; in hexadecimal with or without leading zeros, or in decimal
//! behind   = time, date, direction, channel, number of the line
//! ```
//!
//! A line may also hold a frame in candump's notation (`605#4000…`) or SLCAN's (`t6058…`), and a table may name its
//! columns in its head (`Time,ID,DLC,Data`).
//!
//! - The meaning of the columns is [inferred](infer) from the lines at the beginning and never changes. Lines that fit
//!   two readings are not read: [`Question`] says which [`Columns`] choose one of them.
//! - Times are plain numbers in a unit that a bus allows, times of the day, or dates. Times of the day without a date
//!   count from midnight of the first day.
//! - What follows a frame is its remark, and becomes the record's comment.
//! - A line with two frames is malformed; both are kept.
//! - A line that looks like a frame and is none is malformed. Any other line is prose, and is passed over.
//! - A last line without line end is read if its length shows that it is whole, or if it has eight bytes.

mod clock;
mod columns;
mod describe;
mod doubt;
mod infer;
mod layout;
mod question;
mod remark;
mod row;
mod table;
mod token;
mod unread;
mod word;

pub use question::Question;
pub use unread::Unread;

use crate::columns::Columns;
use crate::formats::candump_log::intern;
use crate::lines::{Line, LineFormat, TextReader};
use crate::{Channels, Damage, DamageKind, Place, ReadOptions, Reader, Record, Source, TimeBase, Timestamp};
use clock::{Clock, date, day_and_time, plain, time_of_day};
use layout::Layout;
use row::{Miss, Row};
use table::Table;
use table::TableRow;
use token::{Token, tokenise};

pub(crate) use remark::remark;
pub(crate) use unread::unread;

/// The name of the channel of lines without channel.
const CHANNEL: &str = "1";

/// The meaning of the lines.
#[derive(Clone)]
enum Meaning {
    Columns(Layout),
    Table(Table),
}

fn infer(head: &[u8], columns: Option<&Columns>) -> Result<Option<Meaning>, Question> {
    if let Some(table) = table::infer(head, columns)? {
        return Ok(Some(Meaning::Table(table)));
    }
    Ok(infer::infer(head, columns)?.map(Meaning::Columns))
}

pub(crate) fn sniff(head: &[u8]) -> bool {
    !matches!(infer(head, None), Ok(None))
}

/// Whether lines that begin like `head` have a meaning.
///
/// # Errors
/// [`Question`] if they fit two readings.
pub(crate) fn has_meaning(head: &[u8], options: &ReadOptions) -> Result<bool, Question> {
    infer(head, options.columns.as_ref()).map(|meaning| meaning.is_some())
}

pub(crate) fn open(source: Source, options: &ReadOptions) -> Box<dyn Reader> {
    let mut pasted = Pasted { columns: options.columns.clone(), ..Pasted::default() };
    if !source.window().is_empty() {
        pasted.infer(source.window());
    }
    Box::new(TextReader::new(source, pasted))
}

#[derive(Default)]
struct Pasted {
    columns: Option<Columns>,
    inferred: bool,
    meaning: Option<Meaning>,
    /// The question that keeps the lines from being read.
    question: Option<Question>,
    clock: Clock,
    /// Whether the head of the table has been read: lines before it are comments.
    headed: bool,
    tokens: Vec<Token>,
    /// The damage of a line from which a frame was read.
    surplus: Option<Damage>,
}

impl Pasted {
    fn infer(&mut self, head: &[u8]) {
        self.inferred = true;
        match infer(head, self.columns.as_ref()) {
            Ok(meaning) => self.meaning = meaning,
            Err(question) => self.question = Some(question),
        }
    }
}

impl LineFormat for Pasted {
    fn begin(&mut self, head: &[u8]) {
        if !self.inferred {
            self.infer(head);
        }
    }

    fn line(&mut self, line: &Line<'_>, channels: &mut Channels) -> Option<Result<Record, Damage>> {
        if line.bytes.trim_ascii().is_empty() {
            return None;
        }
        match self.meaning.take()? {
            Meaning::Columns(layout) => {
                let item = self.columns_line(line, &layout, channels);
                self.meaning = Some(Meaning::Columns(layout));
                item
            }
            Meaning::Table(table) => {
                let item = self.table_line(line, &table, channels);
                self.meaning = Some(Meaning::Table(table));
                item
            }
        }
    }

    fn owed(&mut self) -> Option<Damage> {
        if let Some(surplus) = self.surplus.take() {
            return Some(surplus);
        }
        let question = self.question.take()?;
        let expected = format!("columns: {question}");
        Some(Damage::new(DamageKind::Unsupported, Place { number: 1, offset: 0 }, expected, b""))
    }

    fn time_base(&self) -> TimeBase {
        self.clock.base()
    }

    fn interpretation(&self) -> Option<String> {
        self.meaning.as_ref().map(Meaning::describe)
    }
}

const NO_TIME: &str = "a time between 1970 and 2554";
/// What a last line without line end lacks.
const REST: &str = "the end of this line, as the frame may go on,";

impl Pasted {
    fn columns_line(
        &mut self,
        line: &Line<'_>,
        layout: &Layout,
        channels: &mut Channels,
    ) -> Option<Result<Record, Damage>> {
        tokenise(line.bytes, layout.commas, &mut self.tokens);
        match row::read(line.bytes, &self.tokens, layout) {
            Ok(row) if !line.ended && row.may_go_on => Some(Err(line.cut(REST))),
            Ok(mut row) => {
                let second = row::second(line.bytes, &self.tokens, layout, row.next);
                if second.as_ref().is_some_and(|second| second.is_next) {
                    row.remark = line.bytes.len();
                }
                let record = self.record(line, row, layout, channels);
                self.surplus = second.map(|second| surplus(line, second, record.as_ref().ok()));
                Some(record)
            }
            Err((at, _)) if !line.ended && doubt::is_begun(line.bytes, &self.tokens, layout, at) => {
                Some(Err(line.cut(REST)))
            }
            Err((at, what)) if doubt::is_like_frame(line.bytes, &self.tokens, layout) => {
                Some(Err(damage(line, at, what)))
            }
            Err(_) => None,
        }
    }

    fn record(
        &mut self,
        line: &Line<'_>,
        row: Row,
        layout: &Layout,
        channels: &mut Channels,
    ) -> Result<Record, Damage> {
        let text = |index: usize| self.tokens.get(index).map(|token| token.text(line.bytes)).unwrap_or_default();
        let no_time = |index: Option<usize>| {
            let at = index.and_then(|index| self.tokens.get(index)).map_or(0, |token| token.start);
            damage(line, at, NO_TIME)
        };
        let time = match (row.date, row.clock, row.time) {
            (None, None, Some(index)) => {
                let mut time = plain(text(index)).ok_or_else(|| no_time(row.time))?;
                if let Some(micros) = row.micros.and_then(|index| plain(text(index))) {
                    time.billionths = time.billionths.saturating_add(micros.billionths / 1_000_000);
                }
                self.clock.plain(time, layout.unit, layout.differences)
            }
            (day, clock, _) => {
                let order = layout.month_first;
                let day = day.map(|index| date(text(index), order).ok_or_else(|| no_time(day))).transpose()?;
                let of_day = clock.map(|index| time_of_day(text(index)).ok_or_else(|| no_time(clock))).transpose()?;
                self.clock.calendar(day, of_day)
            }
        };
        let time = time.ok_or_else(|| no_time(row.time.or(row.date)))?;
        let name = row.channel.map_or(CHANNEL.as_bytes(), text);
        let channel = intern(name, channels).map_err(|missing| line.damage(missing))?;
        let direction = row.record.direction;
        let record = row.record.seen(time, channel, direction, line.place);
        Ok(match remark(line.bytes.get(row.remark..).unwrap_or_default()) {
            Some(text) if !remark::shows_data(text, record.data()) => record.with_comment(text),
            _ => record,
        })
    }

    fn table_line(
        &mut self,
        line: &Line<'_>,
        table: &Table,
        channels: &mut Channels,
    ) -> Option<Result<Record, Damage>> {
        if table.is_head(line.bytes) {
            self.headed = true;
            return None;
        }
        if !self.headed {
            return None;
        }
        match table.row(line.bytes) {
            Ok(row) if !line.ended && row.may_go_on => Some(Err(line.cut(REST))),
            Ok(row) => {
                let name = if row.channel.is_empty() { CHANNEL.as_bytes() } else { row.channel };
                let channel = match intern(name, channels) {
                    Ok(channel) => channel,
                    Err(missing) => return Some(Err(line.damage(missing))),
                };
                let Some(time) = self.table_time(&row, table) else {
                    return Some(Err(line.malformed(NO_TIME)));
                };
                let direction = row.record.direction;
                Some(Ok(row.record.seen(time, channel, direction, line.place)))
            }
            Err(_) if !line.ended && line.bytes.iter().any(u8::is_ascii_digit) => Some(Err(line.cut(REST))),
            Err((at, what)) if table.is_like_row(line.bytes) => Some(Err(damage(line, at, what))),
            Err(_) => None,
        }
    }

    fn table_time(&mut self, row: &TableRow<'_>, table: &Table) -> Option<Timestamp> {
        let text = row.time;
        if text.is_empty() && row.date.is_empty() {
            return self.clock.calendar(None, None);
        }
        if let Some(time) = plain(text).filter(|_| row.date.is_empty()) {
            return self.clock.plain(time, table.unit, false);
        }
        if let Some(of_day) = time_of_day(text).or_else(|| day_and_time(text)).filter(|_| row.date.is_empty()) {
            return self.clock.calendar(None, Some(of_day));
        }
        // The date may have a column of its own, and the time of the day may follow it.
        let (day, rest) = match row.date {
            [] => text.split_at_checked(text.iter().position(|byte| *byte == b' ').unwrap_or(text.len()))?,
            date => date.split_at_checked(date.iter().position(|byte| *byte == b' ').unwrap_or(date.len()))?,
        };
        let clock = if row.date.is_empty() || text.is_empty() { rest.trim_ascii() } else { text };
        let of_day = if clock.is_empty() { None } else { Some(time_of_day(clock)?) };
        self.clock.calendar(Some(date(day, table.month_first)?), of_day)
    }
}

/// The damage of a line with a second frame, which has the time and channel of the first one.
fn surplus(line: &Line<'_>, second: row::Second, first: Option<&Record>) -> Damage {
    let damage = damage(line, second.at, "one frame in each line");
    match first {
        Some(first) if second.is_next => {
            let direction = second.record.direction;
            damage.with_salvaged(second.record.seen(first.timestamp, first.channel, direction, line.place))
        }
        _ => damage,
    }
}

/// The damage at an offset in the line.
fn damage(line: &Line<'_>, at: usize, what: &'static str) -> Damage {
    let (expected, found): (Miss, &[u8]) = ((at, what), line.bytes.get(at..).unwrap_or_default());
    line.damage(crate::grammar::Expected::new(found, expected.1))
}
