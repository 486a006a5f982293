//! Infers the meaning of the columns of pasted lines from the lines at the beginning.
//!
//! Every layout that columns can have is tried on all lines. A layout is taken if it gives frames, contradicts few lines
//! that look like frames, and has a proof: a length that is always the number of bytes, labels, a prefix of hexadecimal
//! numbers, or identifiers that could be nothing else. Rows of a hex dump have increasing addresses in the place of
//! identifiers.

mod doubts;
mod proof;
mod roles;
mod sample;

use super::columns::layouts;
use super::layout::{Behind, Core, DataForm, Layout, Role, Words, hash};
use super::question::Question;
use super::row::Row;
use super::token::{Commas, Kind, Token, tokenise};
use super::word::Word;
use crate::columns::Columns;
use crate::lines::head_lines;
use doubts::{bytes, dates, identifiers, length, long_identifiers, radix};
use proof::is_proven;
use roles::{behind, is_arrow_a_mark, roles, time};
use sample::Sample;
use std::collections::BTreeMap;

/// The layout of lines that begin like `head`; `None` if they hold no frames.
pub(super) fn infer(head: &[u8], columns: Option<&Columns>) -> Result<Option<Layout>, Question> {
    if has_decimal_commas(head)
        && let Some(layout) = infer_with(head, columns, Commas::Decimal)?
    {
        return Ok(Some(layout));
    }
    infer_with(head, columns, Commas::Separate)
}

/// Whether a word has the form of a time with a decimal comma.
fn has_decimal_commas(head: &[u8]) -> bool {
    let mut tokens = Vec::new();
    let lines = head_lines(head).map(|(line, _)| line).filter(|line| memchr::memchr(b',', line).is_some());
    lines.take(100).any(|line| {
        tokenise(line, Commas::Decimal, &mut tokens);
        tokens.iter().take(3).any(|token| token.kind != Kind::Other && memchr::memchr(b',', token.text(line)).is_some())
    })
}

fn infer_with(head: &[u8], columns: Option<&Columns>, commas: Commas) -> Result<Option<Layout>, Question> {
    let sample = Sample::new(head, commas);
    let candidates = columns.map_or_else(candidates, layouts);
    let Some(mut layout) = choose(&sample, candidates, columns.is_some()) else { return Ok(None) };
    layout.commas = commas;
    layout.wide_is_standard |= sample.hints.flags;
    let rows = sample.rows(&layout);
    if columns.is_none() {
        roles(&sample, &rows, &mut layout)?;
    }
    behind(&sample, &rows, &mut layout);
    layout.arrow_is_mark = is_arrow_a_mark(&sample, &rows);
    layout.id_digits = id_digits(&sample, &rows, &layout);
    let with_label = rows.iter().filter(|(_, row)| row.other_label).count();
    layout.has_labels = columns.is_some() || 2 * with_label >= rows.len();
    time(&sample, &mut layout, columns)?;
    ask(&sample, &mut layout, columns)?;
    Ok(Some(layout))
}

/// Asks for what is still in doubt.
fn ask(sample: &Sample<'_>, layout: &mut Layout, columns: Option<&Columns>) -> Result<(), Question> {
    if !columns.is_some_and(Columns::decides_wide_ids) {
        identifiers(sample, layout)?;
    }
    if !columns.is_some_and(Columns::decides_dates) {
        dates(sample, layout)?;
    }
    if columns.is_none() {
        length(sample, layout)?;
    }
    if !columns.is_some_and(Columns::decides_data) {
        bytes(sample, layout)?;
    }
    if !columns.is_some_and(Columns::decides_ids) {
        long_identifiers(sample, layout)?;
    }
    if columns.is_none() { radix(sample, layout) } else { Ok(()) }
}

/// The numbers of digits of the identifiers, as bits. Without a length only usual ones count, for other lines may be
/// prose; leading zeros are before all identifiers or before none.
fn id_digits(sample: &Sample<'_>, rows: &[(usize, Row)], layout: &Layout) -> u16 {
    // A strange number with a text behind it may be prose.
    let is_whole = |(line, row): &&(usize, Row)| {
        row.next == sample.tokens(*line).len() || row.id.is_some_and(|id| matches!(id.digits, 3 | 4 | 8))
    };
    let ids = || rows.iter().filter(is_whole).filter_map(|(_, row)| row.id);
    let of_four = ids().filter(|id| id.digits == 4).count();
    let is_usual = |digits: u8| match digits {
        3 | 8 => true,
        4 => 2 * of_four >= rows.len(),
        _ => layout.has(Role::Length),
    };
    ids().filter(|id| is_usual(id.digits)).fold(0, |bits, id| bits | 1 << id.digits.min(15))
}

/// All layouts, the most specific ones first.
fn candidates() -> Vec<Layout> {
    let before = |count: usize| vec![Role::Skip; count];
    let mut all = Vec::new();
    for core in [Core::Notation, Core::Slcan] {
        all.extend((0..=2).map(|count| Layout::new(before(count), core, DataForm::Padded)));
    }
    for id_is_decimal in [false, true] {
        for data in [DataForm::Padded, DataForm::Compact, DataForm::Unpadded, DataForm::Decimal] {
            for gap in [&[Role::Length][..], &[Role::Skip, Role::Length], &[]] {
                for count in 0..=4 {
                    let roles = [&before(count)[..], &[Role::Id], gap].concat();
                    let layout = Layout::new(roles, Core::Apart, data);
                    all.push(Layout { id_is_decimal, ..layout });
                }
            }
        }
    }
    // socketcand writes the time between identifier and data.
    all.extend((0..=1).map(|count| {
        Layout::new([&before(count)[..], &[Role::Id, Role::Time]].concat(), Core::Apart, DataForm::Compact)
    }));
    let has_length = |layout: &&Layout| layout.has(Role::Length) && !layout.id_is_decimal;
    let counted: Vec<_> =
        all.iter().filter(has_length).map(|layout| Layout { behind: Behind::Counter, ..layout.clone() }).collect();
    all.extend(counted);
    all
}

/// The first layout that reads nearly as many lines as the best one, and that has a proof.
fn choose(sample: &Sample<'_>, candidates: Vec<Layout>, given: bool) -> Option<Layout> {
    let proven = candidates.into_iter().filter_map(|layout| {
        let layout = with_words(sample, layout, given);
        let rows = sample.rows(&layout);
        let count = rows.len();
        let is_right = count > 0 && (given || is_proven(sample, &layout, rows));
        is_right.then_some((layout, count))
    });
    let proven: Vec<_> = proven.collect();
    let most = |decimal: bool| {
        proven.iter().filter(|(layout, _)| layout.id_is_decimal == decimal).map(|(_, rows)| *rows).max()
    };
    let (hex, decimal) = (most(false).unwrap_or(0), most(true).unwrap_or(0));
    // Most tools write identifiers in hexadecimal, so a few damaged lines don't make them decimal.
    let is_decimal = given && hex == 0 || 3 * hex < 2 * decimal;
    let most = if is_decimal { decimal } else { hex };
    let fits = |(layout, rows): &(Layout, usize)| layout.id_is_decimal == is_decimal && rows * 5 >= most * 4;
    let (layout, rows) = proven.into_iter().find(fits)?;
    (given || 2 * rows >= sample.alike()).then_some(layout)
}

/// Restricts the unknown words of a layout to words that occur in at least two of its rows, or in one if the user gave
/// the columns.
fn with_words(sample: &Sample<'_>, layout: Layout, given: bool) -> Layout {
    let mut lines_with: BTreeMap<u64, usize> = BTreeMap::new();
    for (line, row) in sample.rows(&layout) {
        let tokens = sample.tokens(line).iter().enumerate().take(row.next);
        let is_unknown = |token: &Token| token.kind == Kind::Word(Word::Unknown);
        let mut words: Vec<_> =
            tokens.filter(|(_, t)| is_unknown(t)).map(|(index, _)| hash(sample.text(line, index))).collect();
        words.sort_unstable();
        words.dedup();
        words.into_iter().for_each(|word| *lines_with.entry(word).or_default() += 1);
    }
    let least = if given { 1 } else { 2 };
    let words = lines_with.into_iter().filter(|(_, lines)| *lines >= least).map(|(word, _)| word).take(64).collect();
    Layout { words: Words::Only(words), ..layout }
}
