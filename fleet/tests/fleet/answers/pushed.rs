//! Filters that are applied before rows are made give the same rows as the engine's own filters.

use super::engine::Engine;
use super::traffic::{self, Random};
use canvass_fleet::table::Table;
use canvass_traces::Format;
use datafusion::arrow::datatypes::DataType;
use serde_json::Value;
use std::path::Path;

/// A condition on a value that the column has, or might have.
fn condition(random: &mut Random, column: &str, kind: &DataType, rows: &[Value]) -> Option<String> {
    let value = rows.get(random.below(rows.len() as u64) as usize).map(|row| row[column].clone())?;
    let literal = match (kind, &value) {
        (_, Value::Null) => return Some(format!("\"{column}\" IS {}NULL", random.of(&["", "NOT "]))),
        (DataType::Boolean, Value::Bool(_)) => return Some(format!("{}\"{column}\"", random.of(&["", "NOT "]))),
        (DataType::Timestamp(..), Value::Number(nanos)) => {
            format!("arrow_cast({nanos}, 'Timestamp(Nanosecond, Some(\"UTC\"))')")
        }
        (DataType::Dictionary(..) | DataType::Utf8, Value::String(text)) => format!("'{}'", text.replace('\'', "''")),
        (_, Value::Number(number)) if !matches!(kind, DataType::Float64) => number.to_string(),
        _ => return None,
    };
    let texts = matches!(kind, DataType::Dictionary(..) | DataType::Utf8);
    Some(match random.below(if texts { 3 } else { 7 }) {
        0 => format!("\"{column}\" = {literal}"),
        1 => format!("\"{column}\" <> {literal}"),
        2 => format!("\"{column}\" IN ({literal}, {literal})"),
        3 => format!("\"{column}\" >= {literal}"),
        4 => format!("{literal} > \"{column}\""),
        5 => format!("\"{column}\" NOT IN ({literal})"),
        _ => format!("\"{column}\" BETWEEN {literal} AND {literal}"),
    })
}

fn statement(random: &mut Random, table: Table, file: &str, rows: &[Value]) -> String {
    let columns = table.columns();
    let names: Vec<&str> = columns.iter().map(|column| column.field.name().as_str()).collect();
    let chosen: Vec<String> = (0..1 + random.below(5)).map(|_| format!("\"{}\"", random.of(&names))).collect();
    let mut chosen = chosen;
    chosen.sort();
    chosen.dedup();
    let conditions: Vec<String> = (0..random.below(4))
        .filter_map(|_| {
            let column = &columns[random.below(columns.len() as u64) as usize].field;
            condition(random, column.name(), column.data_type(), rows)
        })
        .collect();
    let word = random.of(&[" AND ", " AND ", " OR "]);
    let filter = if conditions.is_empty() { String::new() } else { format!(" WHERE {}", conditions.join(word)) };
    match random.below(5) {
        0 => format!("SELECT count(*) AS rows FROM {}('{file}'){filter}", table.name()),
        1 => format!("SELECT {} FROM {}('{file}'){filter} LIMIT {}", chosen.join(", "), table.name(), random.below(20)),
        _ => format!("SELECT {} FROM {}('{file}'){filter}", chosen.join(", "), table.name()),
    }
}

/// Number of questions to each table of each capture.
const QUESTIONS: usize = 3;

/// Tables whose rows need single frames only: columns that are not requested are not even read.
const OF_FRAMES: [Table; 4] = [Table::Frames, Table::Messages, Table::Events, Table::Signals];

/// Makes random queries of a capture, with both engines.
fn ask(engines: &[Engine; 2], tables: &[Table], file: &Path, seed: u64) {
    let [pushing, plain] = engines;
    let mut random = Random::new(seed + 1000);
    for table in tables {
        let rows = plain.table(table.name(), file);
        for _ in 0..QUESTIONS {
            let statement = statement(&mut random, *table, &file.display().to_string(), &rows);
            assert_eq!(pushing.rows(&statement), plain.rows(&statement), "seed {seed}: {statement}");
        }
    }
}

fn generated(seeds: std::ops::Range<u64>, tables: &[Table]) {
    let (engines, folder) = ([true, false].map(Engine::pushing), tempfile::tempdir().unwrap());
    let formats: Vec<Format> = Format::all().collect();
    for seed in seeds {
        let file = traffic::write(folder.path(), formats[seed as usize % formats.len()], seed);
        ask(&engines, tables, &file, seed);
    }
}

#[test]
fn random_projections_and_filters_of_all_tables() {
    let tables: Vec<Table> = Table::ALL.into_iter().filter(|table| !table.is_of_results()).collect();
    generated(0..20, &tables);
}

#[test]
fn random_projections_and_filters_of_frames() {
    generated(20..110, &OF_FRAMES);
}

#[test]
fn random_projections_and_filters_of_more_frames() {
    generated(110..200, &OF_FRAMES);
}

#[test]
fn random_projections_and_filters_of_samples() {
    let engines = [true, false].map(Engine::pushing);
    for (sample, seed) in super::samples().iter().zip(200..) {
        ask(&engines, &OF_FRAMES, sample, seed);
    }
}

/// Nearly all lines of a long log are skipped before they are parsed.
#[test]
fn a_filter_of_a_log() {
    let (engines, folder) = ([true, false].map(Engine::pushing), tempfile::tempdir().unwrap());
    for seed in 0..3 {
        let file = traffic::log(folder.path(), seed, 6_000);
        for asked in [
            "SELECT count(*) AS n, max(number) AS last FROM messages('FILE') WHERE node = 2 AND service = 'sdo'",
            "SELECT number, t, meaning FROM messages('FILE') WHERE node = 2 AND index = 6144",
            "SELECT number, t, data FROM frames('FILE') WHERE can_id = 385",
            "SELECT number, t, value FROM signals('FILE') WHERE node = 3 AND index = 24580",
            "SELECT t, event, detail FROM events('FILE')",
            "SELECT number, state FROM messages('FILE') WHERE service = 'heartbeat' AND state <> 'operational'",
        ] {
            let asked = asked.replace("FILE", &file.display().to_string());
            let [pushed, plain] = engines.each_ref().map(|engine| engine.rows(&asked));
            assert!(!plain.is_empty(), "{asked}");
            assert_eq!(pushed, plain, "seed {seed}: {asked}");
        }
    }
}

#[test]
fn a_limit_stops_reading() {
    let engine = Engine::new();
    let folder = tempfile::tempdir().unwrap();
    let file = traffic::write(folder.path(), Format::Candump, 1);
    let rows = engine.rows(&format!("SELECT t FROM frames('{}') LIMIT 3", file.display()));
    assert_eq!(rows.len(), 3);
    let plan = engine.rows(&format!("EXPLAIN SELECT t FROM frames('{}') WHERE can_id = 5 LIMIT 3", file.display()));
    let text = serde_json::to_string(&plan).unwrap();
    assert!(text.contains("CaptureScan") && text.contains("fetch=3") && text.contains("tests=[can_id]"), "{text}");
    assert!(!text.contains("FilterExec"), "{text}");
}
