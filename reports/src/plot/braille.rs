//! A plot for a terminal, drawn with the eight dots of braille characters.

use super::{Panel, Plot};
use std::fmt::Write as _;

/// Lines of characters of a panel.
const ROWS: usize = 10;
/// Dots of a character across and down.
const ACROSS: usize = 2;
const DOWN: usize = 4;
/// The bits of the dots of U+2800, by row and column.
const DOTS: [[u8; ACROSS]; DOWN] = [[0x01, 0x08], [0x02, 0x10], [0x04, 0x20], [0x40, 0x80]];
/// The room for the marks.
const MARGIN: usize = 14;
/// The narrowest drawing.
const NARROWEST: usize = 20;

/// The dots of a panel.
struct Canvas {
    width: usize,
    cells: Vec<u8>,
}

impl Canvas {
    fn new(columns: usize) -> Self {
        Self { width: columns, cells: vec![0; columns * ROWS] }
    }

    fn set(&mut self, x: usize, y: usize) {
        let cell = y / DOWN * self.width + x / ACROSS;
        if let Some(cell) = self.cells.get_mut(cell) {
            *cell |= DOTS[y % DOWN][x % ACROSS];
        }
    }

    /// Draws a line from one dot to another.
    fn line(&mut self, from: (usize, usize), to: (usize, usize)) {
        let steps = from.0.abs_diff(to.0).max(from.1.abs_diff(to.1)).max(1);
        for step in 0..=steps {
            let between = |from: usize, to: usize| {
                let (from, to) = (from as f64, to as f64);
                (from + (to - from) * step as f64 / steps as f64).round() as usize
            };
            self.set(between(from.0, to.0), between(from.1, to.1));
        }
    }

    fn rows(&self) -> impl Iterator<Item = String> {
        let character = |cell: &u8| char::from_u32(0x2800 + u32::from(*cell)).unwrap_or(' ');
        self.cells.chunks(self.width).map(move |row| row.iter().map(character).collect())
    }
}

impl Plot {
    /// The plot as text of at most `width` characters in a line. The names come from the bus: they are not escaped.
    pub fn text(&self, width: usize) -> String {
        let columns = width.saturating_sub(MARGIN + 2).max(NARROWEST);
        let mut text = String::new();
        for panel in &self.panels {
            self.panel_text(panel, columns, &mut text);
        }
        let seconds = self.seconds();
        let end = format!("{} s", seconds.text(seconds.high));
        let room = columns.saturating_sub(end.len() + 1);
        // Writing to a string can't fail.
        let _ = writeln!(text, "{:MARGIN$}  0{:room$}{end}", "", "");
        let _ = writeln!(text, "{:MARGIN$}  0 s is {}", "", self.begins);
        text
    }

    fn panel_text(&self, panel: &Panel, columns: usize, text: &mut String) {
        for curve in &panel.curves {
            let _ = writeln!(text, "{:MARGIN$}  {}", "", curve.name);
        }
        let mut canvas = Canvas::new(columns);
        let (across, down) = (columns * ACROSS - 1, ROWS * DOWN - 1);
        for curve in &panel.curves {
            let dots = curve.points.iter().map(|&(time, value)| {
                let x = (self.across(time) * across as f64).round() as usize;
                let y = ((1.0 - panel.axis.along(value)) * down as f64).round() as usize;
                (x, y)
            });
            let mut before = None;
            for dot in dots {
                canvas.line(before.unwrap_or(dot), dot);
                before = Some(dot);
            }
        }
        let unit = if panel.unit.is_empty() { String::new() } else { format!(" {}", panel.unit) };
        let mark = |row: usize| match row {
            0 => format!("{}{unit}", panel.axis.text(panel.axis.high)),
            row if row + 1 == ROWS => format!("{}{unit}", panel.axis.text(panel.axis.low)),
            _ => String::new(),
        };
        for (row, dots) in canvas.rows().enumerate() {
            let _ = writeln!(text, "{:>MARGIN$} │{dots}", mark(row));
        }
    }
}
