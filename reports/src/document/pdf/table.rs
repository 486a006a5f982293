//! Tables: columns as wide as their texts need, rows that are not torn apart, and a head on every page.

use super::flow::{Flow, MARGIN, Mark, Style, WIDTH};
use super::fonts::Typeface;
use crate::document::{Align, Row, Table, Tone};
use crate::escape::printable;

const CELL: Style = Style::new(Typeface::Regular, 8.5);
const HEAD: Style = Style::new(Typeface::Bold, 8.5);
/// The space between two columns, and above and below a row.
const GAP: f32 = 8.0;
const PAD: f32 = 2.5;
/// The height of a row to write into by hand.
const BY_HAND: f32 = 30.0;
/// The largest part of the width that a single word may ask for.
const LONGEST_WORD: f32 = 0.35;

/// The columns, each with its left edge and its width.
type Columns = Vec<(f32, f32)>;

pub(super) fn table(flow: &mut Flow<'_>, table: &Table) {
    if table.rows.is_empty() {
        return;
    }
    let columns = columns(flow, table);
    let has_head = table.columns.iter().any(|column| !column.name.is_empty());
    let begin = |flow: &mut Flow<'_>| {
        if has_head {
            head(flow, table, &columns);
        }
    };
    flow.need(HEAD.line() + CELL.line() + 4.0 * PAD);
    begin(flow);
    let by_hand = table.class == "signatures";
    for row in &table.rows {
        let lines = lines(flow, row, &columns);
        let most = lines.iter().map(Vec::len).max().unwrap_or(1);
        let height = (most as f32 * CELL.line() + 2.0 * PAD).max(if by_hand { BY_HAND } else { 0.0 });
        if flow.need(height) {
            begin(flow);
        }
        put(flow, table, row, &columns, &lines);
        flow.y += height;
        flow.mark(Mark::Line { x: flow.left, y: flow.y, width: WIDTH - MARGIN - flow.left });
    }
}

fn head(flow: &mut Flow<'_>, table: &Table, columns: &Columns) {
    let height = HEAD.line() + 2.0 * PAD;
    flow.mark(Mark::Box { x: flow.left, y: flow.y, width: flow.width(), height });
    for (column, &(x, width)) in table.columns.iter().zip(columns) {
        let text = printable(&column.name);
        let at = aligned(flow, &text, HEAD, column.align, x, width);
        flow.text(at, flow.y + PAD, HEAD, &text);
    }
    flow.y += height;
}

fn put(flow: &mut Flow<'_>, table: &Table, row: &Row, columns: &Columns, lines: &[Vec<String>]) {
    let top = flow.y + PAD;
    for (((cell, lines), column), &(x, width)) in row.cells.iter().zip(lines).zip(&table.columns).zip(columns) {
        let tone = if cell.tone == Tone::Plain { row.tone } else { cell.tone };
        let style = CELL.tone(if row.cells.len() > 2 { cell.tone } else { tone });
        for (number, line) in lines.iter().enumerate() {
            let at = aligned(flow, line, style, column.align, x, width);
            flow.text(at, top + number as f32 * style.line(), style, line);
        }
    }
}

fn aligned(flow: &Flow<'_>, text: &str, style: Style, align: Align, x: f32, width: f32) -> f32 {
    let free = (width - flow.fonts.width(text, style.typeface, style.size)).max(0.0);
    match align {
        Align::Left => x,
        Align::Center => x + free / 2.0,
        Align::Right => x + free,
    }
}

fn lines(flow: &Flow<'_>, row: &Row, columns: &Columns) -> Vec<Vec<String>> {
    let cells = row.cells.iter().zip(columns);
    cells.map(|(cell, (_, width))| flow.fonts.lines(&printable(&cell.text), CELL.typeface, CELL.size, *width)).collect()
}

/// The widths of the columns: as much as their texts need, if there is room; otherwise the wide ones share what the
/// narrow ones leave, and no column is narrower than its longest word.
fn columns(flow: &Flow<'_>, table: &Table) -> Columns {
    let count = table.columns.len();
    let room = flow.width() - GAP * count.saturating_sub(1) as f32 - 2.0 * PAD;
    let texts = |at: usize| {
        let cells = table.rows.iter().filter_map(move |row| row.cells.get(at).map(|cell| printable(&cell.text)));
        let name = table.columns.get(at).map(|column| printable(&column.name));
        name.into_iter().chain(cells)
    };
    let width = |text: &str| flow.fonts.width(text, HEAD.typeface, HEAD.size);
    let wanted: Vec<f32> = (0..count).map(|at| texts(at).map(|text| width(&text)).fold(0.0, f32::max)).collect();
    let least = |at: usize| {
        let words = texts(at).map(|text| text.split(' ').map(width).fold(0.0, f32::max));
        words.fold(0.0, f32::max).min(room * LONGEST_WORD)
    };
    let least: Vec<f32> = (0..count).map(least).collect();
    let widths =
        if table.class == "signatures" { vec![room / count as f32; count] } else { shared(&wanted, &least, room) };
    let mut left = flow.left + PAD;
    let place = |width: f32| {
        let x = left;
        left += width + GAP;
        (x, width)
    };
    widths.into_iter().map(place).collect()
}

/// The widths that columns get of the room.
fn shared(wanted: &[f32], least: &[f32], room: f32) -> Vec<f32> {
    if wanted.iter().sum::<f32>() <= room {
        return wanted.to_vec();
    }
    // Columns that want less than an equal share get what they want; the others share the rest.
    let mut widths = vec![0.0; wanted.len()];
    let mut open: Vec<usize> = (0..wanted.len()).collect();
    let mut rest = room;
    while !open.is_empty() {
        let share = rest / open.len() as f32;
        let (narrow, wide): (Vec<usize>, Vec<usize>) = open.iter().partition(|at| wanted[**at] <= share);
        if narrow.is_empty() {
            let total: f32 = wide.iter().map(|at| wanted[*at].max(1.0).sqrt()).sum();
            for at in wide {
                widths[at] = (rest * wanted[at].max(1.0).sqrt() / total).max(least[at]);
            }
            break;
        }
        for at in narrow {
            widths[at] = wanted[at];
            rest -= wanted[at];
        }
        open = wide;
    }
    let sum: f32 = widths.iter().sum();
    if sum > room { widths.iter().map(|width| width * room / sum).collect() } else { widths }
}
