//! Rows of the trace as the page shows them.

use super::store::{Step, Store};
use canvass_analyzer::network::sdo::Violation;
use canvass_analyzer::wire::sdo::{Request, Response};
use canvass_analyzer::{Meaning, Message, Service};
use canvass_reports::escape::printable;
use canvass_reports::time::{Clock, TimeStyle};
use canvass_traces::{Channels, Record, Timestamp};
use serde::Serialize;
use std::fmt::Write as _;

/// A frame as the page shows it. Control characters in its texts are made visible.
#[derive(Debug, Serialize)]
pub struct Row {
    /// The index of the frame among all frames, from 0.
    pub row: usize,
    /// The line or packet of the frame in its file.
    pub place: u64,
    /// Seconds since the first frame.
    pub time: String,
    /// The time as in the capture.
    pub absolute: String,
    /// Seconds since the previous frame.
    pub delta: String,
    /// The name of the channel.
    pub channel: String,
    /// The CAN-ID.
    pub id: String,
    /// The data bytes.
    pub data: String,
    /// The node that the frame concerns.
    pub node: Option<u8>,
    /// The service of the frame.
    pub service: &'static str,
    /// The meaning of the frame.
    pub text: String,
    /// Whether the frame reports a failure.
    pub bad: bool,
}

impl Row {
    /// The row of a step; `time` counts from `start`, `delta` from the previous frame.
    pub fn new(step: &Step<'_>, channels: &Channels, start: Timestamp, before: Option<Timestamp>) -> Self {
        let Step { row, record, decoded, network } = step;
        let text = network.bus(record.channel).map(|bus| Meaning::new(record, decoded, bus).to_string());
        let id = record.frame.id();
        let digits = if id.is_extended() { 8 } else { 3 };
        Self {
            row: *row,
            place: record.place.number,
            time: since(start, record.timestamp),
            absolute: shown(TimeStyle::Absolute, record.timestamp),
            delta: since(before.unwrap_or(record.timestamp), record.timestamp),
            channel: printable(channels.name(record.channel)).into_owned(),
            id: format!("{:0digits$X}", record.frame.printed_id()),
            data: data(record),
            node: decoded.node.map(canvass_analyzer::NodeId::raw),
            service: decoded.service.name(),
            text: printable(&text.unwrap_or_default()).into_owned(),
            bad: is_bad(decoded.service, &decoded.message, decoded.violation),
        }
    }
}

/// Whether a frame reports a failure. Users look for failures first.
pub(super) fn is_bad(service: Service, message: &Message, violation: Option<Violation>) -> bool {
    let aborted = matches!(
        message,
        Message::SdoRequest(Request::Abort(_)) | Message::SdoResponse(Response::Abort(_)) | Message::Malformed(..)
    );
    let gone = matches!(message, Message::Emcy(emcy) if emcy.code().is_some_and(|code| code.0 >> 8 == 0));
    aborted || violation.is_some() || service == Service::ErrorFrame || (service == Service::Emcy && !gone)
}

/// Maximum number of data bytes in a row.
const SHOWN: usize = 64;

fn data(record: &Record) -> String {
    if record.frame.is_remote() {
        let len = record.frame.len();
        return format!("remote, {len} byte{}", if len == 1 { "" } else { "s" });
    }
    let data = record.data();
    let mut text = String::with_capacity(3 * data.len().min(SHOWN));
    for (at, byte) in data.iter().take(SHOWN).enumerate() {
        // Writing to a string can't fail.
        let _ = write!(text, "{}{byte:02X}", if at == 0 { "" } else { " " });
    }
    if data.len() > SHOWN {
        text.push('…');
    }
    text
}

/// A time since the start, in seconds.
pub fn since(start: Timestamp, time: Timestamp) -> String {
    let mut out = Vec::new();
    let mut clock = Clock::new(TimeStyle::Relative);
    clock.push(start, &mut out);
    out.clear();
    clock.push(time, &mut out);
    String::from_utf8_lossy(&out).into_owned()
}

/// A time in this style.
pub fn shown(style: TimeStyle, time: Timestamp) -> String {
    let mut out = Vec::new();
    Clock::new(style).push(time, &mut out);
    String::from_utf8_lossy(&out).into_owned()
}

/// The rows with these indexes, which must be in order.
pub fn rows(store: &Store, places: &[usize], channels: &Channels) -> Vec<Row> {
    let mut rows = Vec::with_capacity(places.len());
    let (Some(&first), Some(&last)) = (places.first(), places.last()) else { return rows };
    let Some(mut walk) = store.walk(first.saturating_sub(1)) else { return rows };
    let start = store.start().unwrap_or_default();
    let mut wanted = places.iter().peekable();
    let mut before = None;
    walk.until(store, last + 1, |step| {
        if wanted.next_if(|place| **place == step.row).is_some() {
            rows.push(Row::new(step, channels, start, before));
        }
        before = Some(step.record.timestamp);
        std::ops::ControlFlow::Continue(())
    });
    rows
}
