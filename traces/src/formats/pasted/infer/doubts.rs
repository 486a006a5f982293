//! Questions where lines fit two readings.

use super::super::layout::{Core, DataForm, Layout, Role};
use super::super::question::{Question, columns_of};
use super::super::row::Row;
use super::Sample;

/// Asks if identifiers of eight digits could have 11 bits.
pub(super) fn identifiers(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
    let rows = sample.rows(layout);
    let in_doubt =
        |row: &Row| row.id.is_some_and(|id| id.digits == 8 && !id.extended && id.hex <= 0x7FF) && !row.width_is_said;
    if layout.wide_is_standard || layout.id_is_decimal || rows.is_empty() || !rows.iter().all(|(_, row)| in_doubt(row))
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

/// Asks if the numbers could be decimal as well as hexadecimal.
pub(super) fn radix(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
    let rows = sample.rows(layout).len();
    let fits = |other: &Layout| sample.rows(other).len() >= rows;
    let unit = layout.unit.symbol();
    if layout.core == Core::Apart && layout.data == DataForm::Unpadded {
        let other = Layout { data: DataForm::Decimal, ..layout.clone() };
        if fits(&other) {
            let columns = ["hex", "dec"].map(|radix| columns_of(layout, unit, "", radix));
            return Err(Question::new("bytes in hex", "bytes in decimal", columns));
        }
    }
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
