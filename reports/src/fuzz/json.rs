//! The result as JSON: `"schema": "canvass/fuzz/1"`.

use super::{Run, Words, rust_test, sdo_rows};
use crate::{escape, provenance};
use canvass_bus::Interruptions;
use canvass_fuzzer::campaign::Found;
use canvass_fuzzer::{FinalState, Kept, Start, Stimulus, Then, reproducer};
use canvass_traces::{Direction, Frame, Record, hex};
use serde_json::{Map, Value, json};
use std::io::{self, Write};

/// The name and version of the contract.
pub const SCHEMA: &str = "canvass/fuzz/1";

/// Writes the document, indented, with a line end.
///
/// # Errors
/// What `out` gives.
pub fn render(run: &Run, out: &mut dyn Write) -> io::Result<()> {
    let document = json!({
        "schema": SCHEMA,
        "version": env!("CARGO_PKG_VERSION"),
        "provenance": provenance::json(&run.provenance),
        "bus": run.bus,
        "bit_rate": run.bit_rate,
        "node": run.node.raw(),
        "model": Some(&run.model).filter(|model| !model.is_empty()),
        "target": run.targets.to_string(),
        "seed": run.seed,
        "repeat": run.repeat,
        "cancelled": run.cancelled,
        "allow": run.allow.iter().map(|touch| touch.name()).collect::<Vec<_>>(),
        "executions": run.outcome.executions,
        "frames": run.outcome.frames,
        "sequences": run.outcome.sequences,
        "unjudged": run.outcome.unjudged,
        "interruptions": run.outcome.interruptions.as_ref().map(interruptions),
        "ended_by": run.outcome.ended_by,
        "dead": run.outcome.dead,
        "left": run.outcome.left.as_ref().map(left),
        "coverage": coverage(run),
        "violations": run.violations().map(|(found, words)| violation(run, found, words)).collect::<Vec<_>>(),
    });
    writeln!(out, "{}", escape::json(&format!("{document:#}")))
}

fn coverage(run: &Run) -> Value {
    let sdo = sdo_rows(run).into_iter().map(|(state, command, answers)| {
        let answers: Map<String, Value> =
            answers.iter().map(|(answer, count)| (answer.name().to_owned(), (*count).into())).collect();
        json!({ "state": state, "command": command, "answers": answers })
    });
    let lss = run.coverage().lss_rows().map(|(state, command, answered, count)| {
        json!({ "state": state.name(), "command": command.name(), "answered": answered, "count": count })
    });
    let (sdo_share, lss_share) = (run.sdo_share(), run.lss_share());
    json!({
        "sdo": { "reached": sdo_share.reached, "reachable": sdo_share.reachable, "pairs": sdo.collect::<Vec<_>>() },
        "lss": { "reached": lss_share.reached, "reachable": lss_share.reachable, "pairs": lss.collect::<Vec<_>>() },
    })
}

/// What the settings hold after the run.
fn left(left: &FinalState) -> Value {
    json!({ "settings": left.settings, "compared": left.compared, "different": left.different.iter().map(state).collect::<Vec<_>>() })
}

/// How the way to the bus was interrupted.
fn interruptions(Interruptions { count, lasted, last, is_over }: &Interruptions) -> Value {
    json!({ "count": count, "duration_ns": lasted.nanos(), "last": last, "over": is_over })
}

/// An object that had not its value of power-on.
fn state(kept: &Kept) -> Value {
    json!({ "index": kept.at.index.0, "sub": kept.at.sub.0, "value": kept.value, "power_on": kept.power_on })
}

fn violation(run: &Run, found: &Found, words: &Words) -> Value {
    let violation = &found.violation;
    let start = match found.sequence.start {
        Start::Configured => "configured",
        Start::Unconfigured => "without-node-id",
    };
    let frames = found.sequence.stimuli.iter().zip(&words.sequence);
    let evidence = found.evidence.iter().zip(&words.evidence);
    json!({
        "property": violation.property.id(),
        "title": violation.property.title(),
        "rule": violation.rule,
        "expected": violation.expected,
        "actual": violation.actual,
        "t": violation.at.nanos(),
        "confirmed": found.confirmed,
        "cut_off": found.is_cut_off,
        "state": found.state.iter().map(state).collect::<Vec<_>>(),
        "start": start,
        "frames": frames.map(|(stimulus, words)| step(stimulus, words)).collect::<Vec<_>>(),
        "evidence": evidence.map(|(record, words)| exhibit(record, words)).collect::<Vec<_>>(),
        "log": reproducer::candump(&found.sequence),
        "test": rust_test(run, found),
    })
}

fn step(stimulus: &Stimulus, words: &str) -> Value {
    let mut value = frame(&stimulus.frame, words);
    let (then, wait) = match stimulus.then {
        Then::Settle => ("settle", None),
        Then::AtOnce => ("at-once", None),
        Then::Pause(time) => ("pause", Some(time.nanos())),
    };
    value.insert("then".to_owned(), then.into());
    if let Some(wait) = wait {
        value.insert("wait_ns".to_owned(), wait.into());
    }
    Value::Object(value)
}

fn exhibit(record: &Record, words: &str) -> Value {
    let mut value = frame(&record.frame, words);
    let direction = if record.direction == Direction::Tx { "tx" } else { "rx" };
    value.insert("t".to_owned(), record.timestamp.nanos().into());
    value.insert("direction".to_owned(), direction.into());
    Value::Object(value)
}

fn frame(frame: &Frame, words: &str) -> Map<String, Value> {
    let data = hex::compact(frame.data()).to_string();
    let mut value = Map::new();
    value.insert("id".to_owned(), frame.id().raw().into());
    if frame.id().is_extended() {
        value.insert("extended".to_owned(), true.into());
    }
    if frame.is_remote() {
        value.insert("remote".to_owned(), true.into());
        value.insert("dlc".to_owned(), frame.len().into());
    }
    value.insert("data".to_owned(), data.into());
    value.insert("text".to_owned(), words.into());
    value
}
