//! Questions where lines fit two readings.

use super::super::clock::order;
use super::super::layout::{Core, DataForm, Given, Layout, Role};
use super::super::question::{Question, columns_of};
use super::super::row::Row;
use super::Sample;
use crate::CanId;

/// Asks if identifiers of eight digits could have 11 bits.
pub(super) fn identifiers(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
    let rows = sample.rows(layout);
    let in_doubt =
        |row: &Row| row.id.is_some_and(|id| id.digits == 8 && !id.extended && id.hex <= 0x7FF) && !row.width_is_said;
    // Where all have eight digits, those of 11 bits may have been filled up.
    let is_wide = |row: &Row| row.id.is_some_and(|id| id.digits == 8 && !id.extended) && !row.width_is_said;
    if layout.wide_is_standard
        || layout.id_is_decimal
        || !rows.iter().any(|(_, row)| in_doubt(row))
        || !rows.iter().all(|(_, row)| is_wide(row))
    {
        return Ok(());
    }
    let columns = ["11", "29"].map(|bits| columns_of(layout, layout.unit.symbol(), bits, ""));
    Err(Question::new("identifiers of 11 bits", "identifiers of 29 bits", columns))
}

/// Asks if the length could be the first byte.
pub(super) fn length(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
    let rows = sample.rows(layout);
    let is_sure = |row: &Row| row.length_is_said || row.record.frame.is_remote();
    if !layout.has(Role::Length) || layout.core != Core::Apart || rows.iter().any(|(_, row)| is_sure(row)) {
        return Ok(());
    }
    let first = rows.first().map(|(_, row)| row.record.frame.len());
    let other = Layout { before: without_length(layout), ..layout.clone() };
    if rows.iter().any(|(_, row)| Some(row.record.frame.len()) != first) || sample.rows(&other).len() < rows.len() {
        return Ok(());
    }
    let columns = [layout, &other].map(|layout| columns_of(layout, layout.unit.symbol(), "", ""));
    Err(Question::new("a length and then the data", "data whose first byte is like a length", columns))
}

fn without_length(layout: &Layout) -> Vec<Role> {
    layout.before.iter().copied().filter(|role| *role != Role::Length).collect()
}

/// Asks if the bytes could be decimal as well as hexadecimal.
pub(super) fn bytes(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
    if layout.core != Core::Apart || layout.data != DataForm::Unpadded {
        return Ok(());
    }
    let other = Layout { data: DataForm::Decimal, ..layout.clone() };
    if sample.rows(&other).len() < sample.rows(layout).len() {
        return Ok(());
    }
    let columns = ["hex", "dec"].map(|radix| columns_of(layout, layout.unit.symbol(), "", radix));
    Err(Question::new("bytes in hex", "bytes in decimal", columns))
}

/// Asks if identifiers that are no usual ones in hexadecimal, such as 1541, could be decimal.
pub(super) fn long_identifiers(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
    if layout.core != Core::Apart || layout.id_is_decimal {
        return Ok(());
    }
    let decimal = Layout { id_is_decimal: true, id_digits: 0, ..layout.clone() };
    let (hex, other) = (sample.rows(layout), sample.rows(&decimal));
    let is_long = |row: &Row| row.id.is_some_and(|id| id.digits == 4 && id.hex > CanId::MAX_STANDARD && !id.is_hex);
    let is_standard = |row: &Row| row.record.frame.id().raw() <= CanId::MAX_STANDARD;
    let long = other.iter().filter(|(_, row)| is_long(row) && is_standard(row)).count();
    // Some damaged lines of hexadecimal identifiers have four digits too.
    let is_sure = 5 * long >= other.len() || other.len() > hex.len() && sample.fits(&decimal);
    if other.len() < hex.len() || !is_sure || long == 0 || !other.iter().all(|(_, row)| is_standard(row)) {
        return Ok(());
    }
    let columns = ["hex", "dec"].map(|radix| columns_of(layout, layout.unit.symbol(), radix, ""));
    Err(Question::new("identifiers in hex", "identifiers in decimal", columns))
}

/// Asks if dates with slashes could begin with the day as well as with the month.
pub(super) fn dates(sample: &Sample<'_>, layout: &mut Layout) -> Result<(), Question> {
    let rows = sample.rows(layout);
    let texts = || rows.iter().filter_map(|(line, row)| row.date.map(|date| sample.text(*line, date)));
    let is_in_doubt = |text: &[u8]| {
        let begin = text.iter().position(|byte| *byte == b'/');
        begin.is_some_and(|digits| digits <= 2)
    };
    if !texts().any(is_in_doubt) {
        return Ok(());
    }
    if let Some(month_first) = texts().find_map(order) {
        layout.month_first = month_first;
        return Ok(());
    }
    let columns = ["mdy", "dmy"].map(|order| {
        let given = Given { date: order.to_owned(), ..layout.given.clone() };
        let layout = Layout { given, ..layout.clone() };
        columns_of(&layout, layout.unit.symbol(), "", "")
    });
    Err(Question::new("dates that begin with the month", "dates that begin with the day", columns))
}

/// Asks if the identifiers could be decimal as well as hexadecimal.
pub(super) fn radix(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
    let rows = sample.rows(layout).len();
    let fits = |other: &Layout| sample.rows(other).len() >= rows;
    let unit = layout.unit.symbol();
    if layout.id_is_decimal {
        let other = Layout { id_is_decimal: false, ..layout.clone() };
        if 3 * sample.rows(&other).len() >= rows {
            let columns = ["hex", "dec"].map(|radix| columns_of(layout, unit, radix, ""));
            return Err(Question::new("identifiers in hex", "identifiers in decimal", columns));
        }
    }
    if layout.core == Core::Apart && layout.data == DataForm::Decimal && !layout.id_is_decimal {
        let other = Layout { id_is_decimal: true, ..layout.clone() };
        if fits(&other) {
            let columns = ["hex", "dec"].map(|radix| columns_of(layout, unit, radix, "dec"));
            return Err(Question::new("identifiers in hex", "identifiers in decimal", columns));
        }
    }
    Ok(())
}
