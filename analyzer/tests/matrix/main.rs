//! The diagnosis, measured by a matrix of incidents: operators on the frames of each service of each node.
//!
//! The matrix knows what was done to the frames, and nothing of the rules. Without the variables below it measures a
//! small sample; `cargo xtask incidents` sets them.
//!
//! - `CANVASS_MATRIX_SEEDS`: seeds, with commas between them;
//! - `CANVASS_MATRIX_COUNT`: number of cells, and of healthy networks, for each seed;
//! - `CANVASS_MATRIX_WRITE`: `CELL@SEED`, written to the file of `CANVASS_MATRIX_FILE` as a log of candump.

#![cfg(test)]

mod cell;
mod draw;
mod judge;
mod measure;
mod network;
mod open;
mod operator;
mod plan;
mod play;
mod relations;
mod sort;
mod wire;

use cell::Cell;
use measure::Measure;
use std::env;
use std::io::Write;

/// The share of cells that the sample must name first or second.
const FLOOR: f64 = 0.85;

#[test]
fn incidents_are_named_and_healthy_networks_are_not_accused() {
    let count = env::var("CANVASS_MATRIX_COUNT").ok().and_then(|count| count.parse().ok());
    let seeds = env::var("CANVASS_MATRIX_SEEDS").unwrap_or_else(|_| "1".to_owned());
    let seeds: Vec<u64> = seeds.split(',').filter_map(|seed| seed.trim().parse().ok()).collect();
    let mut measure = Measure::default();
    if let Ok(cell) = env::var("CANVASS_MATRIX_WRITE") {
        return write(&cell);
    }
    measure.cells(&seeds, count.unwrap_or(100));
    measure.healthy(&seeds, count.unwrap_or(42));
    say(&measure.report());
    assert!(measure.accused.is_empty(), "{:#?}", measure.accused);
    assert!(measure.share() >= FLOOR, "{:.3} of the cells are named first or second", measure.share());
}

/// Prints a text, for whom `--nocapture` shows it.
fn say(text: &str) {
    // A closed output changes nothing that the test checks.
    let _ = writeln!(std::io::stdout(), "{text}");
}

/// Writes the records of a cell, or of a healthy network.
fn write(name: &str) {
    let (id, seed) = name.rsplit_once('@').expect("the cell is CELL@SEED");
    let seed = seed.parse().expect("the seed is a number");
    let records = match id.strip_prefix("healthy/") {
        Some(number) => play::play(
            &measure::healthy(seed, number.parse().expect("the network is a number")).plan,
            &std::collections::HashMap::new(),
        ),
        None => {
            let cell = Cell::by_id(id).expect("a cell of the matrix: BASE/KNOWN/SERVICE/MESSAGE/OPERATOR/WHEN");
            let (_, records, truth) = cell.records(seed).expect("the network of the cell sends such a message");
            say(&truth.to_string());
            records
        }
    };
    let log: String = records.iter().map(relations::line).collect();
    std::fs::write(env::var("CANVASS_MATRIX_FILE").expect("the file is given"), log).expect("the file is writable");
}

#[test]
fn patterns_of_what_cannot_be_known_are_of_cells_and_have_reasons() {
    let ids: Vec<String> = Cell::all().iter().map(ToString::to_string).collect();
    for (pattern, reason) in open::Open::read().patterns() {
        assert!(reason.len() > 20, "{pattern}: {reason}");
        assert!(ids.iter().any(|id| open::matches(pattern, id)), "no cell is {pattern}");
    }
}
