//! Details of one frame.

use super::rows::{shown, since};
use super::store::{Step, Store};
use canvass_analyzer::network::sdo::Outcome;
use canvass_analyzer::{Meaning, TransferText};
use canvass_reports::decode::{JsonLines, Line, Lines as _, TimeStyle};
use canvass_reports::escape::printable;
use canvass_reports::events::{Events as _, Scene, TextEvents};
use canvass_traces::{Channels, Timestamp};
use serde_json::{Value, json};
use std::ops::ControlFlow;

/// The details of the frame of a row; `null` if there is no such row.
pub fn details(store: &Store, row: usize, channels: &Channels) -> Value {
    let Some(mut walk) = store.walk(row) else { return Value::Null };
    walk.until(store, row, |_| ControlFlow::Continue(()));
    let mut details = Value::Null;
    walk.until(store, row + 1, |step| {
        details = of(step, channels, store.start().unwrap_or_default());
        ControlFlow::Continue(())
    });
    details
}

fn of(step: &Step<'_>, channels: &Channels, start: Timestamp) -> Value {
    let Step { row, record, decoded, network } = step;
    let Some(bus) = network.bus(record.channel) else { return Value::Null };
    let line = Line { record, channels, decoded, meaning: Meaning::new(record, decoded, bus) };
    let mut as_json = Vec::new();
    JsonLines::new().line(&line, &mut as_json);
    let scene =
        Scene { time: record.timestamp, channel: channels.name(record.channel), bus, frame: Some((record, decoded)) };
    let mut text = TextEvents::new(TimeStyle::Relative, false);
    let events = bus.events().iter().map(|event| {
        let mut shown = Vec::new();
        text.event(&scene, event, &mut shown);
        printable(String::from_utf8_lossy(&shown).trim()).into_owned()
    });
    let signals = line.meaning.signals().map(|signal| {
        let name = signal.name().map(|name| name.to_string()).unwrap_or_default();
        let value = signal.scaled().map(|(number, unit)| (number, unit.symbol.to_string()));
        let value =
            value.or_else(|| signal.value().map(|(n, unit)| (n, unit.map_or(String::new(), |u| u.symbol.to_string()))));
        json!({
            "object": signal.multiplexer().to_string(),
            "name": printable(&name),
            "value": value.as_ref().map(|(number, _)| number.as_f64()),
            "unit": value.as_ref().map(|(_, unit)| printable(unit)),
        })
    });
    json!({
        "row": row,
        "place": record.place.number,
        "time": since(start, record.timestamp),
        "absolute": shown(TimeStyle::Absolute, record.timestamp),
        "utc": shown(TimeStyle::Utc, record.timestamp),
        "bytes": record.data().iter().take(64).collect::<Vec<_>>(),
        "text": printable(&line.meaning.to_string()),
        "object": decoded.object.map(|object| object.to_string()),
        "objectName": line.meaning.object_name().map(|name| printable(&name.to_string()).into_owned()),
        "signals": signals.collect::<Vec<_>>(),
        "events": events.collect::<Vec<_>>(),
        "transfer": transfer(step, start),
        "json": String::from_utf8_lossy(&as_json).trim(),
    })
}

/// The outcome of a transfer as text.
fn outcome(outcome: Outcome) -> String {
    match outcome {
        Outcome::Open => "under way".to_owned(),
        Outcome::Complete => "complete".to_owned(),
        Outcome::Aborted(side, code) => format!("aborted by {side}: {code}"),
        Outcome::Superseded => "given up: the client began another one".to_owned(),
    }
}

/// The SDO transfer to which the frame belongs, up to this frame.
fn transfer(step: &Step<'_>, start: Timestamp) -> Option<Value> {
    let channel = step.decoded.channel?;
    let bus = step.network.bus(step.record.channel)?;
    let transfer = bus.transfer(channel)?;
    let text = TransferText::new(bus, bus.server(channel)?, transfer);
    Some(json!({
        "object": printable(&text.object().to_string()),
        "value": (transfer.length() > 0).then(|| printable(&text.value().to_string()).into_owned()),
        "outcome": outcome(transfer.outcome),
        "direction": format!("{:?}", transfer.direction).to_lowercase(),
        "mode": format!("{:?}", transfer.mode).to_lowercase(),
        "began": since(start, transfer.started),
        "beganAt": transfer.started.nanos().to_string(),
        "lasted": transfer.latest.since(transfer.started).nanos() / 1000,
        "segments": transfer.segments,
    }))
}
