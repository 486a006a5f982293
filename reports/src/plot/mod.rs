//! Values of PDOs as curves over time.

mod axis;
mod braille;
mod svg;

use crate::signals::{Columns, SampleRow, Series, Sheet};
use axis::Axis;
use canvass_analyzer::Number;
use canvass_traces::Timestamp;
use std::io;

/// Collects the chosen columns, in bounded memory and with every peak.
pub struct Curves {
    /// The words that a column's name must contain, for each wish. Without wishes all columns are chosen.
    wishes: Vec<String>,
    /// The place of each column among the chosen ones.
    places: Vec<Option<usize>>,
    /// The chosen columns.
    chosen: Vec<usize>,
    series: Series,
    changed: Vec<(usize, Number)>,
    /// Number of columns that were chosen, but left out because there are too many.
    pub left_out: usize,
}

/// The curves of one unit, which have one axis.
struct Panel {
    unit: String,
    curves: Vec<Curve>,
    axis: Axis,
}

struct Curve {
    name: String,
    points: Vec<(Timestamp, f64)>,
}

/// The curves of a capture, ready to be drawn.
pub struct Plot {
    panels: Vec<Panel>,
    from: Timestamp,
    to: Timestamp,
    /// The time of the left end, as a caption.
    begins: String,
}

impl Curves {
    /// Curves of the columns whose names contain all words of one of the wishes, in any case; of all columns if there
    /// is no wish.
    pub fn new(wishes: &[String]) -> Self {
        Self {
            wishes: wishes.iter().map(|wish| wish.to_lowercase()).collect(),
            places: Vec::new(),
            chosen: Vec::new(),
            series: Series::default(),
            changed: Vec::new(),
            left_out: 0,
        }
    }

    fn is_wished(&self, name: &str) -> bool {
        let name = name.to_lowercase();
        self.wishes.is_empty()
            || self.wishes.iter().any(|wish| wish.split_whitespace().all(|word| contains_word(&name, word)))
    }

    /// The place of a column among the chosen ones.
    fn place(&mut self, column: usize, columns: &Columns) -> Option<usize> {
        while self.places.len() <= column {
            let next = self.places.len();
            let is_wished = columns.iter().nth(next).is_some_and(|column| self.is_wished(&column.name));
            let has_room = self.chosen.len() < Series::MOST;
            self.left_out += usize::from(is_wished && !has_room);
            self.places.push((is_wished && has_room).then_some(self.chosen.len()));
            if is_wished && has_room {
                self.chosen.push(next);
            }
        }
        self.places.get(column).copied().flatten()
    }

    /// The plot of the curves; `None` if no column was chosen, or none has a finite value. `begins` is the caption of
    /// the left end.
    pub fn plot(&self, columns: &Columns, begins: impl Fn(Timestamp) -> String) -> Option<Plot> {
        let mut panels: Vec<(String, Vec<Curve>)> = Vec::new();
        for (place, at) in self.chosen.iter().enumerate() {
            let Some(column) = columns.iter().nth(*at) else { continue };
            let points = self.series.points(place);
            if points.is_empty() {
                continue;
            }
            let curve = Curve { name: column.name.clone(), points };
            match panels.iter_mut().find(|(unit, _)| !unit.is_empty() && *unit == column.unit) {
                Some((_, curves)) => curves.push(curve),
                None => panels.push((column.unit.clone(), vec![curve])),
            }
        }
        let times =
            || panels.iter().flat_map(|(_, curves)| curves).flat_map(|curve| &curve.points).map(|point| point.0);
        let (from, to) = (times().min()?, times().max()?);
        let panels = panels.into_iter().map(|(unit, curves)| {
            let values = || curves.iter().flat_map(|curve| &curve.points).map(|point| point.1);
            let axis = Axis::new(values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
            Panel { unit, axis, curves }
        });
        Some(Plot { panels: panels.collect(), from, to, begins: begins(from) })
    }
}

/// Whether a name contains the word; a number is not found inside another number.
fn contains_word(name: &str, word: &str) -> bool {
    let is_digit = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_digit);
    let bytes = name.as_bytes();
    name.match_indices(word).any(|(at, _)| {
        let before = at.checked_sub(1).and_then(|before| bytes.get(before));
        let begins = !is_digit(word.as_bytes().first()) || !is_digit(before);
        begins && (!is_digit(word.as_bytes().last()) || !is_digit(bytes.get(at + word.len())))
    })
}

impl Sheet for Curves {
    fn row(&mut self, row: &SampleRow<'_>, columns: &Columns, out: &mut Vec<u8>) -> io::Result<()> {
        self.changed.clear();
        for &(column, number) in row.changed {
            if let Some(place) = self.place(column, columns) {
                self.changed.push((place, number));
            }
        }
        let row = SampleRow { time: row.time, source: row.source, changed: &self.changed };
        self.series.row(&row, columns, out)
    }

    fn finish(&mut self, _columns: &Columns, _out: &mut Vec<u8>) -> io::Result<bool> {
        Ok(false)
    }
}

impl Plot {
    /// The position of a time between the left end, 0, and the right one, 1.
    fn across(&self, time: Timestamp) -> f64 {
        let whole = self.to.since(self.from).nanos();
        if whole == 0 { 0.5 } else { time.since(self.from).nanos() as f64 / whole as f64 }
    }

    /// The axis of the time since the left end, in seconds.
    fn seconds(&self) -> Axis {
        Axis::exact(0.0, self.to.since(self.from).nanos() as f64 / 1e9)
    }
}

#[cfg(test)]
mod tests;
