//! What proves that lines are frames.

use super::super::layout::{Core, DataForm, Layout, Role, Words};
use super::super::row::Row;
use super::super::token::{Kind, Token};
use super::Sample;
use crate::{CanId, Direction};

/// Whether the lines can hardly be anything but frames.
pub(super) fn is_proven(sample: &Sample<'_>, layout: &Layout, rows: Vec<(usize, Row)>) -> bool {
    let (remote, rows): (Vec<_>, Vec<_>) = rows.into_iter().partition(|(_, row)| row.record.frame.is_remote());
    match layout.core {
        Core::Notation => true,
        // `r1234` may be a revision, and `t1230` any name.
        Core::Slcan => rows.iter().any(|(_, row)| !row.record.frame.is_empty()),
        // A number and `r` may be anything: labels, or frames with data in the same columns, prove that it is a frame.
        Core::Apart if rows.is_empty() => remote.iter().any(|(_, row)| row.labelled),
        Core::Apart => are_columns_proven(sample, layout, &rows),
    }
}

fn are_columns_proven(sample: &Sample<'_>, layout: &Layout, rows: &[(usize, Row)]) -> bool {
    let is_labelled = rows.iter().any(|(_, row)| row.labelled);
    let ids = || rows.iter().filter_map(|(_, row)| row.id);
    let most = rows.iter().map(|(_, row)| row.record.frame.len()).max().unwrap_or(0);
    // The lines may have numbers of other things in the place of identifiers.
    let is_small = |id: u32| id <= CanId::MAX_STANDARD;
    let are_ids = if layout.id_is_decimal {
        ids().any(|id| id.digits >= 3) && ids().all(|id| id.decimal().is_some_and(is_small))
    } else {
        ids().any(|id| id.digits >= 3)
    };
    if !is_labelled && !are_ids {
        return false;
    }
    if !layout.has(Role::Length) {
        return matches!(layout.data, DataForm::Padded | DataForm::Compact)
            && (is_labelled || are_without_length(sample, layout, rows, most));
    }
    match layout.data {
        // A single row such as `100 2 10 aa` may stand in any text.
        DataForm::Padded => has_hex(sample, rows) && (is_labelled || rows.len() > 1 || most >= 4 || is_seen(rows)),
        DataForm::Compact => is_labelled || most >= 4 || rows.len() > 1 && most >= 3,
        // Short rows of small numbers may be anything.
        DataForm::Unpadded | DataForm::Decimal => most >= 4 || rows.len() > 1 && most >= 2,
    }
}

/// Whether lines without length and labels are frames.
fn are_without_length(sample: &Sample<'_>, layout: &Layout, rows: &[(usize, Row)], most: usize) -> bool {
    let is_source = |(line, row): &(usize, Row)| {
        row.id.is_some_and(|id| id.is_hex) && data_tokens(sample.tokens(*line), row).any(is_prefixed)
    };
    let has_other_words = layout.words != Words::Only(Vec::new());
    let is_long = if layout.data == DataForm::Compact { most == 8 } else { most >= 4 };
    !is_dump(rows)
        && !has_other_words
        && !rows.iter().any(is_source)
        && are_bare_ids(rows)
        && (is_long || is_seen(rows) && rows.len() > 1 && layout.data == DataForm::Padded)
        && (layout.data == DataForm::Compact || has_hex(sample, rows))
}

fn is_prefixed(token: &Token) -> bool {
    token.number().is_some_and(|number| number.is_hex)
}

/// Whether a byte could not be a decimal number.
fn has_hex(sample: &Sample<'_>, rows: &[(usize, Row)]) -> bool {
    let is_hex = |token: &Token| match token.number() {
        Some(number) => number.is_hex || !number.is_decimal || number.digits == 2 && number.hex < 0x10,
        None => token.kind == Kind::Digits,
    };
    rows.iter().any(|(line, row)| data_tokens(sample.tokens(*line), row).any(is_hex))
}

/// Whether the lines say where or in which direction the frames were seen.
fn is_seen(rows: &[(usize, Row)]) -> bool {
    rows.iter().any(|(_, row)| row.record.direction != Direction::Unknown || row.channel.is_some())
}

/// The tokens of the data.
fn data_tokens<'t>(tokens: &'t [Token], row: &Row) -> impl Iterator<Item = &'t Token> {
    let count = row.record.frame.len();
    let values =
        tokens.iter().take(row.next).rev().filter(|token| matches!(token.kind, Kind::Number(_) | Kind::Digits));
    values.take(count.max(1))
}

/// Whether the identifiers are the addresses of a dump: each is that of the line before plus its number of bytes.
fn is_dump(rows: &[(usize, Row)]) -> bool {
    let pair = |pair: &[(usize, Row)]| match pair {
        [(_, a), (_, b)] => b.record.frame.id().raw() == a.record.frame.id().raw() + a.record.frame.len() as u32,
        _ => false,
    };
    rows.len() > 1 && rows.windows(2).all(pair)
}

/// Whether identifiers without label and length have the usual number of digits.
fn are_bare_ids(rows: &[(usize, Row)]) -> bool {
    let ids = rows.iter().filter_map(|(_, row)| row.id);
    let usual = ids.filter(|id| id.digits == 3 || id.extended || id.digits == 4 || id.digits == 8);
    let three = rows.iter().filter_map(|(_, row)| row.id).any(|id| id.digits == 3 || id.extended);
    usual.count() == rows.len() && (three || rows.len() >= 2)
}
