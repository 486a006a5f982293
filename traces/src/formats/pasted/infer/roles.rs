//! The meaning of the numbers beside the identifier and the data, and the unit of the times.

use super::super::clock::{plain, units};
use super::super::layout::{Behind, Core, Layout, Role};
use super::super::question::{Question, columns_of};
use super::super::row::Row;
use super::super::token::{Kind, Token};
use super::Sample;
use crate::columns::Unit;

/// Gives the numbers before the identifier their meaning.
pub(super) fn roles(sample: &Sample<'_>, rows: &[(usize, Row)], layout: &mut Layout) {
    let mut has_time = rows.iter().any(|(_, row)| row.clock.is_some() || row.date.is_some());
    let mut has_channel = rows.iter().any(|(_, row)| row.channel.is_some());
    let end = layout.before.iter().position(|role| *role == Role::Id).unwrap_or(layout.before.len());
    for column in 0..end {
        let values: Vec<(Token, &[u8])> =
            rows.iter().filter_map(|(line, _)| nth_value(sample, *line, column)).collect();
        let role = role(&values, has_time, has_channel);
        has_time |= role == Role::Time;
        has_channel |= role == Role::Channel;
        if let Some(place) = layout.before.get_mut(column) {
            *place = role;
        }
    }
}

fn nth_value<'a>(sample: &Sample<'a>, line: usize, column: usize) -> Option<(Token, &'a [u8])> {
    let mut values = sample.tokens(line).iter().enumerate().filter(|(_, token)| token.is_value());
    values.nth(column).map(|(index, token)| (*token, sample.text(line, index)))
}

fn role(values: &[(Token, &[u8])], has_time: bool, has_channel: bool) -> Role {
    let numbers: Option<Vec<_>> = values.iter().map(|(_, text)| plain(text)).collect();
    let Some(numbers) = numbers.filter(|numbers| !numbers.is_empty()) else { return Role::Skip };
    if numbers.iter().any(|number| number.decimals > 0) {
        return if has_time { Role::Skip } else { Role::Time };
    }
    let whole: Vec<u128> = numbers.iter().map(|number| number.billionths / 1_000_000_000).collect();
    let steps = || whole.windows(2).map(|pair| pair[1].checked_sub(pair[0]));
    let is_closed = values.iter().all(|(token, _)| token.number().is_some_and(|number| number.closed));
    let by_one = steps().filter(|step| *step == Some(1)).count();
    if is_closed || whole.len() > 1 && 5 * by_one >= 4 * (whole.len() - 1) {
        return Role::Skip;
    }
    let (most, grows) = (whole.iter().max().copied().unwrap_or(0), whole.last() > whole.first());
    match () {
        () if !has_time && grows && most >= 100 && steps().all(|step| step.is_some()) => Role::Time,
        () if !has_channel && most < 100 => Role::Channel,
        () => Role::Skip,
    }
}

/// What follows the data.
pub(super) fn behind(sample: &Sample<'_>, rows: &[(usize, Row)], layout: &mut Layout) {
    let values = || {
        rows.iter().map(|(line, row)| sample.tokens(*line).get(row.next).filter(|token| token.kind == Kind::Fraction))
    };
    if layout.core != Core::Apart || !values().all(|value| value.is_some()) {
        return;
    }
    if sample.hints.cycle {
        layout.behind = Behind::CycleAndCount;
        return;
    }
    let times: Vec<_> = rows.iter().filter_map(|(line, row)| plain(sample.text(*line, row.next))).collect();
    let grow = times.windows(2).all(|pair| pair[0].billionths <= pair[1].billionths);
    if grow && !layout.has(Role::Time) && rows.iter().all(|(_, row)| row.clock.is_none()) {
        layout.behind = Behind::Time;
    }
}

/// Finds the unit of the times.
pub(super) fn time(sample: &Sample<'_>, layout: &mut Layout, given: Option<Unit>) -> Result<(), Question> {
    let rows = sample.rows(layout);
    let texts = || rows.iter().filter_map(|(line, row)| row.time.map(|token| sample.text(*line, token)));
    let mut times: Vec<_> = texts().filter_map(plain).collect();
    if times.is_empty() {
        return Ok(());
    }
    let down = times.windows(2).filter(|pair| pair[1].billionths < pair[0].billionths).count();
    layout.differences = down > 0 && down * 10 >= times.len();
    if layout.differences {
        let mut sum = 0_u128;
        for time in &mut times {
            sum = time.billionths.saturating_add(sum);
            time.billionths = sum;
        }
    }
    // PEAK's older rows have numbers with a parenthesis, and times in milliseconds.
    let is_peak = rows.iter().all(|(line, _)| {
        sample.tokens(*line).first().and_then(Token::number).is_some_and(|number| number.closed && number.is_decimal)
    }) && times.iter().all(|time| (1..=3).contains(&time.decimals));
    let units = units(&times);
    layout.unit = match given.or(sample.hints.unit).or(is_peak.then_some(Unit::Millis)) {
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
