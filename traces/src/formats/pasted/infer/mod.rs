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
use super::layout::{Core, DataForm, Layout, Role, Words, hash};
use super::question::Question;
use super::token::{Kind, Token};
use super::word::Word;
use crate::columns::Columns;
use doubts::{identifiers, length, radix};
use proof::is_proven;
use roles::{behind, roles, time};
use sample::Sample;
use std::collections::BTreeMap;

/// The layout of lines that begin like `head`; `None` if they hold no frames.
pub(super) fn infer(head: &[u8], columns: Option<&Columns>) -> Result<Option<Layout>, Question> {
    let sample = Sample::new(head);
    let candidates = columns.map_or_else(candidates, layouts);
    let Some(mut layout) = choose(&sample, candidates, columns.is_some()) else { return Ok(None) };
    layout.wide_is_standard |= sample.hints.flags;
    let rows = sample.rows(&layout);
    if columns.is_none() {
        roles(&sample, &rows, &mut layout);
    }
    behind(&sample, &rows, &mut layout);
    time(&sample, &mut layout, columns.and_then(Columns::unit))?;
    if !columns.is_some_and(Columns::decides_wide_ids) {
        identifiers(&sample, &layout)?;
    }
    if columns.is_none() {
        length(&sample, &layout)?;
        radix(&sample, &layout)?;
    }
    Ok(Some(layout))
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
