//! Infers the meaning of the columns of pasted lines from the lines at the beginning.
//!
//! Every layout that columns can have is tried on all lines. A layout is taken if it gives frames, contradicts few lines
//! that look like frames, and has a proof: a length that is always the number of bytes, labels, a prefix of hexadecimal
//! numbers, or identifiers that could be nothing else. Rows of a hex dump have increasing addresses in the place of
//! identifiers.

use super::clock::{Unit, plain, units};
use super::columns::Columns;
use super::layout::{Behind, Core, DataForm, Layout, Role, Words, hash};
use super::question::{Question, columns_of};
use super::row::{Row, read};
use super::token::{Kind, Token, tokenise};
use super::word::Word;
use crate::lines::head_lines;
use crate::{CanId, Direction};
use std::collections::BTreeMap;

/// Number of lines that decide.
const LINES: usize = 300;

/// The lines that decide, each with its tokens.
struct Sample<'a> {
    lines: Vec<(&'a [u8], Vec<Token>)>,
    hints: Hints,
}

/// What lines without frames, such as the heads of tables, say of the columns.
#[derive(Default)]
struct Hints {
    unit: Option<Unit>,
    /// A column with flags says which identifiers have 29 bits.
    flags: bool,
    /// A column with cycle times.
    cycle: bool,
}

impl<'a> Sample<'a> {
    fn new(head: &'a [u8]) -> Self {
        let mut sample = Self { lines: Vec::new(), hints: Hints::default() };
        for (line, _) in head_lines(head).filter(|(line, _)| !line.trim_ascii().is_empty()) {
            let mut tokens = Vec::new();
            tokenise(line, &mut tokens);
            let has_value = |token: &Token| token.is_value() || matches!(token.kind, Kind::Notation | Kind::Slcan);
            if tokens.iter().any(has_value) {
                sample.lines.push((line, tokens));
            }
            if sample.lines.len() < 50 {
                sample.hints.look_at(line);
            }
            if sample.lines.len() == LINES {
                break;
            }
        }
        sample
    }

    /// The lines that a layout reads as frames with data, each with its index.
    fn rows(&self, layout: &Layout) -> Vec<(usize, Row)> {
        let row = |(index, (line, tokens)): (usize, &(&[u8], Vec<Token>))| {
            let row = read(line, tokens, layout).ok()?;
            let has_content =
                row.record.frame.is_remote() || !row.record.frame.is_empty() || layout.core != Core::Apart;
            has_content.then_some((index, row))
        };
        self.lines.iter().enumerate().filter_map(row).collect()
    }

    /// Number of lines with two or more bytes in a row, or with a whole frame.
    fn alike(&self) -> usize {
        let is_byte = |token: &Token| token.number().is_some_and(|number| number.digits == 2 && !number.extended);
        let is_whole = |token: &Token| matches!(token.kind, Kind::Digits | Kind::Notation | Kind::Slcan);
        let alike =
            |tokens: &[Token]| tokens.iter().any(is_whole) || tokens.windows(2).any(|pair| pair.iter().all(is_byte));
        self.lines.iter().filter(|(_, tokens)| alike(tokens)).count()
    }

    fn tokens(&self, line: usize) -> &[Token] {
        self.lines.get(line).map_or(&[], |(_, tokens)| tokens)
    }

    fn text(&self, line: usize, token: usize) -> &'a [u8] {
        let line = self.lines.get(line);
        line.and_then(|(line, tokens)| Some(tokens.get(token)?.text(line))).unwrap_or_default()
    }
}

impl Hints {
    fn look_at(&mut self, line: &[u8]) {
        let lower = line.to_ascii_lowercase();
        let has = |text: &str| lower.windows(text.len()).any(|window| window == text.as_bytes());
        self.flags |= has("identifier flg") || has(" flg ");
        self.cycle |= has("cycle time");
        for unit in Unit::ALL {
            let symbol = unit.symbol();
            let is_named = has(&format!("[{symbol}]")) || has(&format!("({symbol})"));
            if is_named && (has("time") || has("offset")) {
                self.unit = self.unit.or(Some(unit));
            }
        }
        // PEAK's rows have a kind and times in milliseconds.
        let is_peak = line.split(u8::is_ascii_whitespace).any(|word| word == b"DT");
        self.unit = self.unit.or(is_peak.then_some(Unit::Millis));
    }
}

/// The layout of lines that begin like `head`; `None` if they hold no frames.
pub(super) fn infer(head: &[u8], columns: Option<&Columns>) -> Result<Option<Layout>, Question> {
    let sample = Sample::new(head);
    let candidates = columns.map_or_else(candidates, Columns::layouts);
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
        let is_right = !rows.is_empty() && (given || is_proven(sample, &layout, &rows));
        is_right.then_some((layout, rows.len()))
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

/// Restricts the unknown words to those that several lines have.
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

/// Whether the lines can hardly be anything but frames.
fn is_proven(sample: &Sample<'_>, layout: &Layout, rows: &[(usize, Row)]) -> bool {
    if layout.core != Core::Apart {
        return true;
    }
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
        DataForm::Padded => has_hex(sample, rows) && (is_labelled || rows.len() > 1 || most > 1 || is_seen(rows)),
        DataForm::Compact => is_labelled || most >= 3,
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
        && (is_long || is_seen(rows) && layout.data == DataForm::Padded)
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

/// Gives the numbers before the identifier their meaning.
fn roles(sample: &Sample<'_>, rows: &[(usize, Row)], layout: &mut Layout) {
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
fn behind(sample: &Sample<'_>, rows: &[(usize, Row)], layout: &mut Layout) {
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
fn time(sample: &Sample<'_>, layout: &mut Layout, given: Option<Unit>) -> Result<(), Question> {
    let rows = sample.rows(layout);
    let texts = || rows.iter().filter_map(|(line, row)| row.time.map(|token| sample.text(*line, token)));
    let mut times: Vec<_> = texts().filter_map(plain).collect();
    if times.is_empty() {
        return Ok(());
    }
    let down = times.windows(2).filter(|pair| pair[1].billionths < pair[0].billionths).count();
    layout.differences = down > 0 && down * 10 >= times.len();
    if layout.differences {
        let mut sum = 0;
        for time in &mut times {
            sum += time.billionths;
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

/// Asks if identifiers of eight digits could have 11 bits.
fn identifiers(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
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
fn length(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
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
fn radix(sample: &Sample<'_>, layout: &Layout) -> Result<(), Question> {
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
