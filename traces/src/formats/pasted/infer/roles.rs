//! The meaning of the numbers beside the identifier and the data, and the unit of the times.

use super::super::clock::{Plain, plain, units};
use super::super::layout::{Behind, Core, Layout, Role};
use super::super::question::{Question, columns_of};
use super::super::row::{Row, clock_at};
use super::super::token::{Kind, Token};
use super::super::word::Word;
use super::Sample;
use crate::Direction;
use crate::columns::{Columns, Unit};

/// Gives the numbers before the identifier their meaning.
pub(super) fn roles(sample: &Sample<'_>, rows: &[(usize, Row)], layout: &mut Layout) -> Result<(), Question> {
    let mut has_time = rows.iter().any(|(_, row)| row.clock.is_some() || row.date.is_some());
    let mut has_channel = rows.iter().any(|(_, row)| row.channel.is_some());
    let end = layout.before.iter().position(|role| *role == Role::Id).unwrap_or(layout.before.len());
    for column in 0..end {
        let values: Vec<(Token, &[u8])> =
            rows.iter().filter_map(|(line, _)| nth_value(sample, *line, column)).collect();
        let is_time_later = !is_sorted(&values) && (column + 1..end).any(|column| is_time_column(sample, rows, column));
        let guess = match () {
            () if is_time_later => Guess::Role(Role::Skip),
            () if !has_time && is_seconds(sample, rows, column, end) => {
                set(layout, column + 1, Role::Micros);
                Guess::Role(Role::Time)
            }
            () if layout.before.get(column) == Some(&Role::Micros) => Guess::Role(Role::Micros),
            () => role(&values, has_time, has_channel),
        };
        let (Guess::Role(role) | Guess::Doubt(role, _)) = guess;
        has_time |= role == Role::Time;
        has_channel |= role == Role::Channel;
        set(layout, column, role);
        if let Guess::Doubt(_, differences) = guess {
            return Err(time_or_channel(layout, column, differences));
        }
    }
    Ok(())
}

type Value<'a> = (Token, &'a [u8]);

/// Whether numbers never decrease.
fn is_sorted(values: &[Value<'_>]) -> bool {
    let times: Vec<_> = values.iter().filter_map(|(_, text)| plain(text)).map(|time| time.billionths).collect();
    times.len() == values.len() && times.is_sorted()
}

/// Whether a column has decimals and never decreases, so that it is the time if one before it decreases.
fn is_time_column(sample: &Sample<'_>, rows: &[(usize, Row)], column: usize) -> bool {
    let values: Vec<_> = rows.iter().filter_map(|(line, _)| nth_value(sample, *line, column)).collect();
    values.len() > 1 && values.iter().all(|(token, _)| token.kind == Kind::Fraction) && is_sorted(&values)
}

/// Whether a column has whole seconds, and the one after it six digits of microseconds.
fn is_seconds(sample: &Sample<'_>, rows: &[(usize, Row)], column: usize, end: usize) -> bool {
    let values = |column: usize| rows.iter().filter_map(move |(line, _)| nth_value(sample, *line, column));
    let six = |(_, text): Value<'_>| text.len() == 6 && text.iter().all(u8::is_ascii_digit);
    let whole: Vec<_> = values(column).collect();
    column + 1 < end
        && rows.len() > 1
        && is_sorted(&whole)
        && whole.iter().all(|(_, text)| text.iter().all(u8::is_ascii_digit))
        && values(column + 1).all(six)
        && !is_sorted(&values(column + 1).collect::<Vec<_>>())
}

fn set(layout: &mut Layout, column: usize, role: Role) {
    if let Some(place) = layout.before.get_mut(column) {
        *place = role;
    }
}

/// Asks whether small numbers are times or channels.
fn time_or_channel(layout: &Layout, column: usize, differences: bool) -> Question {
    let columns = [Role::Time, Role::Channel].map(|role| {
        let mut layout = Layout { differences, unit: Unit::Millis, ..layout.clone() };
        set(&mut layout, column, role);
        columns_of(&layout, "ms", "", "")
    });
    let times = if differences { "times since the line before in ms" } else { "times in ms" };
    Question::new(times, "numbers of channels", columns)
}

/// The meaning of a column of numbers.
enum Guess {
    Role(Role),
    /// Small numbers that may be times or channels, and whether the times would be differences.
    Doubt(Role, bool),
}

fn nth_value<'a>(sample: &Sample<'a>, line: usize, column: usize) -> Option<(Token, &'a [u8])> {
    let mut values = sample.tokens(line).iter().enumerate().filter(|(_, token)| token.is_value());
    values.nth(column).map(|(index, token)| (*token, sample.text(line, index)))
}

fn role(values: &[(Token, &[u8])], has_time: bool, has_channel: bool) -> Guess {
    let numbers: Option<Vec<_>> = values.iter().map(|(_, text)| plain(text)).collect();
    let Some(numbers) = numbers.filter(|numbers| !numbers.is_empty()) else { return Guess::Role(Role::Skip) };
    if numbers.iter().any(|number| number.decimals > 0) {
        return Guess::Role(if has_time { Role::Skip } else { Role::Time });
    }
    let whole: Vec<u128> = numbers.iter().map(|number| number.billionths / 1_000_000_000).collect();
    let steps = || whole.windows(2).map(|pair| pair[1].checked_sub(pair[0]));
    let is_closed = values.iter().all(|(token, _)| token.number().is_some_and(|number| number.closed));
    let by_one = steps().filter(|step| *step == Some(1)).count();
    if is_closed || whole.len() > 1 && 5 * by_one >= 4 * (whole.len() - 1) {
        return Guess::Role(Role::Skip);
    }
    let (most, grows) = (whole.iter().max().copied().unwrap_or(0), whole.last() > whole.first());
    let is_sorted = steps().all(|step| step.is_some());
    // A bus has few channels, which come again and again.
    let mut distinct = whole.clone();
    distinct.sort_unstable();
    distinct.dedup();
    let are_few = 2 * distinct.len() <= whole.len() + 1;
    match () {
        () if !has_time && grows && most >= 100 && is_sorted => Guess::Role(Role::Time),
        () if !has_channel && most < 100 && are_few => Guess::Role(Role::Channel),
        () if !has_channel && most < 100 && !has_time => Guess::Doubt(Role::Time, !is_sorted),
        () => Guess::Role(Role::Skip),
    }
}

/// What follows the data.
pub(super) fn behind(sample: &Sample<'_>, rows: &[(usize, Row)], layout: &mut Layout) {
    let values = || {
        rows.iter().map(|(line, row)| sample.tokens(*line).get(row.next).filter(|token| token.kind == Kind::Fraction))
    };
    if layout.core != Core::Apart || layout.behind != Behind::Nothing {
        return;
    }
    let has_clock = |(line, row): &(usize, Row)| {
        row.clock.is_none() && row.date.is_none() && clock_at(sample.tokens(*line), row.next).is_some()
    };
    if rows.len() > 1 && rows.iter().all(has_clock) {
        layout.behind = Behind::Clock;
        return;
    }
    if !values().all(|value| value.is_some()) {
        return;
    }
    if sample.hints.cycle || is_list(sample, rows) {
        layout.behind = Behind::CycleAndCount;
        return;
    }
    let times: Vec<_> = rows.iter().filter_map(|(line, row)| plain(sample.text(*line, row.next))).collect();
    let grow = times.windows(2).all(|pair| pair[0].billionths <= pair[1].billionths);
    if grow && !layout.has(Role::Time) && rows.iter().all(|(_, row)| row.clock.is_none()) {
        layout.behind = Behind::Time;
    }
}

/// Whether the rows are a list of the last frames: a cycle time and a count end each, and no identifier comes again.
fn is_list(sample: &Sample<'_>, rows: &[(usize, Row)]) -> bool {
    let has_count = |(line, row): &(usize, Row)| {
        let rest = sample.tokens(*line).get(row.next + 1..);
        matches!(rest, Some([count]) if count.number().is_some_and(|number| number.is_decimal))
    };
    let mut ids: Vec<_> = rows.iter().map(|(_, row)| row.record.frame.id()).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.len() == rows.len() && rows.iter().all(has_count)
}

/// Whether each row has `->` after its time of the day, as the monitor of the Arduino IDE writes it.
pub(super) fn is_arrow_a_mark(sample: &Sample<'_>, rows: &[(usize, Row)]) -> bool {
    rows.iter().all(|(line, row)| {
        let is_arrow = row.clock == Some(0) && sample.text(*line, 1) == b"->";
        is_arrow && row.record.direction == Direction::Tx
    })
}

/// The unit that a word after each time says.
fn said_unit(sample: &Sample<'_>, rows: &[(usize, Row)]) -> Option<Unit> {
    let said = |(line, row): &(usize, Row)| {
        let unit = Unit::by_symbol(sample.text(*line, row.time? + 1));
        unit.filter(|unit| *unit != Unit::Seconds)
    };
    let first = rows.first().and_then(said)?;
    rows.iter().all(|row| said(row) == Some(first)).then_some(first)
}

/// Whether times are differences: they decrease again and again. A clock that starts again decreases once.
fn differences(times: &[Plain], layout: &Layout) -> Result<bool, Question> {
    let down = times.windows(2).filter(|pair| pair[1].billionths < pair[0].billionths).count();
    if down >= 3 {
        return Ok(5 * down >= times.len());
    }
    if down == 0 || 3 * down < times.len() - 1 {
        return Ok(false);
    }
    let columns = [false, true].map(|differences| {
        let layout = Layout { differences, ..layout.clone() };
        columns_of(&layout, layout.unit.symbol(), "", "")
    });
    Err(Question::new("times", "times since the line before", columns))
}

/// Finds the unit of the times.
pub(super) fn time(sample: &Sample<'_>, layout: &mut Layout, columns: Option<&Columns>) -> Result<(), Question> {
    let given = columns.and_then(Columns::unit);
    let rows = sample.rows(layout);
    let texts = || rows.iter().filter_map(|(line, row)| row.time.map(|token| sample.text(*line, token)));
    let mut times: Vec<_> = texts().filter_map(plain).collect();
    if times.is_empty() {
        return Ok(());
    }
    if columns.is_none() {
        layout.differences = differences(&times, layout)?;
    }
    if layout.differences {
        let mut sum = 0_u128;
        for time in &mut times {
            sum = time.billionths.saturating_add(sum);
            time.billionths = sum;
        }
    }
    // PEAK's older rows have numbers with a parenthesis, its newer ones a kind; both have times in milliseconds.
    let is_peak = |(line, _): &(usize, Row)| {
        let tokens = sample.tokens(*line);
        let is_kind = |token: &Token| token.kind == Kind::Word(Word::Usual) && token.text(sample.line(*line)) == b"DT";
        let is_numbered = tokens.first().and_then(Token::number).is_some_and(|n| n.closed && n.is_decimal);
        is_numbered || tokens.iter().any(is_kind)
    };
    let is_peak = rows.iter().all(is_peak) && times.iter().all(|time| (1..=3).contains(&time.decimals));
    let units = units(&times);
    let is_split = layout.has(Role::Micros).then_some(Unit::Seconds);
    let said = given.or(is_split).or_else(|| said_unit(sample, &rows)).or(sample.hints.unit);
    layout.unit = match said.or(is_peak.then_some(Unit::Millis)) {
        Some(unit) => unit,
        None => match units[..] {
            [first, second, ..] => {
                let columns = [first, second].map(|unit| columns_of(layout, unit.symbol(), "", ""));
                let reading = |unit: Unit| format!("times in {}", unit.symbol());
                return Err(Question::new(reading(first), reading(second), columns));
            }
            [unit] => unit,
            [] => Unit::Seconds,
        },
    };
    Ok(())
}
