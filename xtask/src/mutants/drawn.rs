//! Numbers the mutants, and draws the mutants to try.

use super::area::Area;
use super::point::Form;
use super::scratch::Source;
use std::collections::BTreeSet;

/// A mutant, with its description for people and for the list of equivalent mutants.
#[derive(Clone, Debug)]
pub struct Mutant {
    /// The number that selects the mutant.
    pub number: u32,
    /// The number of the first mutant at the same place; a run records this number when it reaches the place.
    pub place: u32,
    pub service: &'static str,
    /// The path of the file below the folder of the area's sources.
    pub file: String,
    pub line: usize,
    pub function: String,
    /// The line of code, without the white space around it.
    pub code: String,
    /// The changed code and its replacement.
    pub change: String,
}

impl Mutant {
    /// The place and the change of the mutant.
    pub fn describe(&self, area: &Area) -> String {
        let Self { number, file, line, function, change, code, .. } = self;
        format!("{number} {}/{file}:{line} {function}: {change}\n    {code}", area.sources)
    }
}

/// All mutants, by number.
pub fn all(sources: &[Source]) -> Vec<Mutant> {
    let mut mutants = Vec::new();
    for source in sources {
        let mut number = source.first;
        for point in &source.found.points {
            let original = source.text.get(point.range.clone()).unwrap_or_default();
            let place = number;
            for variant in &point.variants {
                mutants.push(Mutant {
                    number,
                    place,
                    service: source.service,
                    file: source.path.clone(),
                    line: point.line,
                    function: point.function.clone(),
                    code: line(&source.text, point.line, point.form),
                    change: change(original, &variant.what),
                });
                number += 1;
            }
        }
    }
    mutants
}

/// Draws `count` mutants at reached places by the seed; all of them if there are no more.
pub fn draw_reached(mutants: &[Mutant], reached: &BTreeSet<u32>, seed: u64, count: usize) -> Vec<Mutant> {
    draw(mutants.iter().filter(|mutant| reached.contains(&mutant.place)).cloned().collect(), seed, count)
}

/// Draws `count` mutants by the seed; all of them if there are no more.
pub fn draw(mut drawn: Vec<Mutant>, seed: u64, count: usize) -> Vec<Mutant> {
    let mut state = seed;
    for at in (1..drawn.len()).rev() {
        drawn.swap(at, (random(&mut state) % (at as u64 + 1)) as usize);
    }
    drawn.truncate(count);
    drawn.sort_by_key(|mutant| mutant.number);
    drawn
}

/// A pseudo-random number (SplitMix64).
fn random(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut mixed = *state;
    mixed = (mixed ^ mixed >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ mixed >> 31
}

fn line(text: &str, number: usize, form: Form) -> String {
    // A body begins at the end of the function's signature, so the line of a body is not the changed code.
    let line = text.lines().nth(number - 1).unwrap_or_default().trim();
    if form == Form::Body { String::new() } else { line.to_owned() }
}

/// The change in the form `a < b: <= between`; long code is cut.
fn change(original: &str, what: &str) -> String {
    let flat: Vec<&str> = original.split_whitespace().collect();
    let flat = flat.join(" ");
    match flat.is_empty() {
        true => what.to_owned(),
        false => format!("{}: {what}", flat.chars().take(60).collect::<String>()),
    }
}
