//! What proves that lines are frames.

use super::super::layout::{Behind, Core, DataForm, Layout, Role, Words};
use super::super::row::Row;
use super::super::token::{Kind, Token};
use super::Sample;
use crate::{CanId, Direction};

/// Whether the lines can hardly be anything but frames.
pub(super) fn is_proven(sample: &Sample<'_>, layout: &Layout, rows: Vec<(usize, Row)>) -> bool {
    let (remote, rows): (Vec<_>, Vec<_>) = rows.into_iter().partition(|(_, row)| row.record.frame.is_remote());
    match layout.core {
        Core::Notation => is_notation_proven(sample, layout, &rows, &remote),
        // `r1234` may be a revision, and `t1230` any name.
        Core::Slcan => rows.iter().any(|(_, row)| !row.record.frame.is_empty()),
        // A number and `r` may be anything: labels, or frames with data in the same columns, prove that it is a frame.
        Core::Apart if rows.is_empty() => remote.iter().any(|(_, row)| row.labelled),
        Core::Apart => are_columns_proven(sample, layout, &rows),
    }
}

/// Whether words such as `123#45` are frames. A reference to a remark or an issue looks like a short one.
fn is_notation_proven(sample: &Sample<'_>, layout: &Layout, rows: &[(usize, Row)], remote: &[(usize, Row)]) -> bool {
    let is_long = |(_, row): &(usize, Row)| row.record.frame.len() >= 4;
    let stands_alone = |(line, row): &(usize, Row)| row.next == 1 && sample.tokens(*line).len() == 1;
    let all = || rows.iter().chain(remote);
    all().any(is_long) || is_seen(rows) || is_seen(remote) || layout.has(Role::Time) || all().all(stands_alone)
}

fn are_columns_proven(sample: &Sample<'_>, layout: &Layout, rows: &[(usize, Row)]) -> bool {
    let is_labelled = rows.iter().any(|(_, row)| row.labelled);
    if !is_labelled && rows.iter().all(|row| is_source(sample, layout, row)) {
        return false;
    }
    if layout.behind == Behind::Counter && !are_counters(sample, rows) {
        return false;
    }
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
        DataForm::Padded => {
            let is_row = rows.len() > 1 || most >= 4 && (has_letters(sample, rows) || has_zeros(rows));
            has_hex(sample, rows) && (is_labelled || is_seen(rows) || is_row && !are_pairs(sample, rows))
        }
        DataForm::Compact => is_labelled || most >= 4 || rows.len() > 1 && most >= 3,
        // Short rows of small numbers may be anything.
        DataForm::Unpadded | DataForm::Decimal => {
            let is_seen = is_labelled || is_seen(rows) || has_letters(sample, rows);
            (most >= 4 || rows.len() > 1 && most >= 2) && (is_seen || is_like_bus(rows) || has_zeros(rows))
        }
    }
}

/// Whether lines without length and labels are frames.
fn are_without_length(sample: &Sample<'_>, layout: &Layout, rows: &[(usize, Row)], most: usize) -> bool {
    let has_other_words = layout.words != Words::Only(Vec::new());
    let is_timed = is_seen(rows)
        || layout.has(Role::Time)
        || rows.iter().any(|(_, row)| row.clock.is_some() || row.date.is_some());
    let is_long = if layout.data == DataForm::Compact { most == 8 } else { most >= 4 };
    !is_dump(rows)
        && !has_other_words
        && are_bare_ids(rows)
        && (!layout.id_is_decimal || rows.iter().any(|(_, row)| row.id.is_some_and(|id| id.hex > CanId::MAX_STANDARD)))
        && (is_long || is_seen(rows) && rows.len() > 1 && layout.data == DataForm::Padded)
        && match layout.data {
            DataForm::Compact => is_timed || is_no_hash(rows),
            _ => has_letters(sample, rows) || has_hex(sample, rows) && is_timed || has_zeros(rows),
        }
}

/// Whether a row is one of an array in a source: all its numbers have a prefix, the one in the place of the length too,
/// or a comma follows the last one.
fn is_source(sample: &Sample<'_>, layout: &Layout, (line, row): &(usize, Row)) -> bool {
    let tokens = sample.tokens(*line);
    let is_prefixed = |token: &Token| token.number().is_some_and(|number| number.is_hex);
    let is_array = row.id.is_some_and(|id| id.is_hex) && data_tokens(tokens, row).any(is_prefixed);
    let values = || tokens.iter().take(row.next).filter(|token| token.is_value());
    is_array && (!layout.has(Role::Length) || values().all(is_prefixed) || sample.ends_in_comma(*line))
}

/// Whether the last column counts the lines.
fn are_counters(sample: &Sample<'_>, rows: &[(usize, Row)]) -> bool {
    let count =
        |(line, _): &(usize, Row)| sample.tokens(*line).last().and_then(Token::number).and_then(|n| n.decimal());
    let counts: Vec<_> = rows.iter().map(count).collect();
    let up = counts.windows(2).filter(|pair| pair[0] < pair[1]).count();
    rows.len() >= 3 && 4 * up >= 3 * (rows.len() - 1)
}

/// Whether a byte has a letter as a digit.
fn has_letters(sample: &Sample<'_>, rows: &[(usize, Row)]) -> bool {
    let has_letter = |token: &Token| token.number().is_some_and(|number| !number.is_decimal);
    rows.iter().any(|(line, row)| data_tokens(sample.tokens(*line), row).any(has_letter))
}

/// Whether all numbers after the identifiers are pairs of decimal digits, as in timetables, the length too. A zero that
/// follows another number is that of a message.
fn are_pairs(sample: &Sample<'_>, rows: &[(usize, Row)]) -> bool {
    let is_padded = |(line, row): &(usize, Row)| {
        let values: Vec<_> = sample.tokens(*line).iter().take(row.end).filter(|token| token.is_value()).collect();
        let length = values.len().checked_sub(row.record.frame.len() + 1).and_then(|at| values.get(at));
        length.and_then(|token| token.number()).is_some_and(|number| number.digits == 2)
    };
    let has_zero = rows.iter().any(|(_, row)| row.record.frame.data().iter().skip(1).any(|byte| *byte == 0));
    !has_letters(sample, rows) && !has_zero && rows.iter().all(is_padded)
}

/// Whether a row has eight bytes with two zeros in a row, as messages have and timetables don't.
fn has_zeros(rows: &[(usize, Row)]) -> bool {
    let zeros = |data: &[u8]| data.len() == 8 && data.windows(2).any(|pair| pair == [0, 0]);
    rows.iter().any(|(_, row)| zeros(row.record.frame.data()))
}

/// Whether lengths differ or identifiers occur again, as on a bus and not in a list.
fn is_like_bus(rows: &[(usize, Row)]) -> bool {
    let lengths = rows.windows(2).any(|pair| pair[0].1.record.frame.len() != pair[1].1.record.frame.len());
    let again = rows.iter().enumerate().any(|(at, (_, row))| {
        rows.iter().skip(at + 1).take(20).any(|(_, other)| other.record.frame.id() == row.record.frame.id())
    });
    again || lengths && rows.iter().any(|(_, row)| row.record.frame.len() == 8)
}

/// Whether data in one word are no hashes or addresses of the same length: most have zeros, or their lengths differ.
fn is_no_hash(rows: &[(usize, Row)]) -> bool {
    let zeros = |row: &Row| row.record.frame.data().iter().filter(|byte| **byte == 0).count() >= 2;
    let is_short = |row: &Row| row.id.is_some_and(|id| id.digits <= 4);
    let with_zeros = rows.iter().filter(|(_, row)| zeros(row)).count();
    let lengths = rows.windows(2).any(|pair| pair[0].1.record.frame.len() != pair[1].1.record.frame.len());
    rows.iter().all(|(_, row)| is_short(row)) && (2 * with_zeros >= rows.len() || lengths)
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
    let values = tokens.iter().take(row.end).rev().filter(|token| matches!(token.kind, Kind::Number(_) | Kind::Digits));
    values.take(count.max(1))
}

/// Whether the identifiers are the addresses of a dump or the numbers of a list: they grow, and most by the same small
/// step. Lines without change may be left out.
fn is_dump(rows: &[(usize, Row)]) -> bool {
    const LARGEST: u32 = 64;
    let id = |row: &(usize, Row)| row.1.record.frame.id().raw();
    let steps: Option<Vec<u32>> =
        rows.windows(2).map(|pair| id(&pair[1]).checked_sub(id(&pair[0])).filter(|step| *step > 0)).collect();
    let Some(mut steps) = steps.filter(|steps| !steps.is_empty()) else { return false };
    steps.sort_unstable();
    let median = steps.get(steps.len() / 2).copied().unwrap_or(0);
    let alike = steps.iter().filter(|step| **step == median).count();
    median <= LARGEST && 2 * alike >= steps.len()
}

/// Whether identifiers without label and length have the usual number of digits.
fn are_bare_ids(rows: &[(usize, Row)]) -> bool {
    let ids = rows.iter().filter_map(|(_, row)| row.id);
    let usual = ids.filter(|id| id.digits == 3 || id.extended || id.digits == 4 || id.digits == 8);
    let three = rows.iter().filter_map(|(_, row)| row.id).any(|id| id.digits == 3 || id.extended);
    // A line of prose may begin with two numbers.
    3 * usual.count() >= 2 * rows.len() && (three || rows.len() >= 2)
}
