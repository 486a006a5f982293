//! JSON Lines: one object per frame, as `docs/json.md` describes it.

use super::{Line, Lines};
use crate::push::{push_decimal, push_hex, push_json_string, push_text};
use canvass_analyzer::network::Source;
use canvass_analyzer::network::sdo::Violation;
use canvass_analyzer::{Meaning, Number, Service, SignalValue};
use canvass_traces::{Direction, Frame};

/// The JSON rendering of `decode` and `monitor`.
#[derive(Default)]
pub struct JsonLines {
    begun: bool,
}

/// The name and version of the contract.
const SCHEMA: &str = "canvass/decode/1";

impl JsonLines {
    /// A rendering that has written nothing yet.
    pub fn new() -> Self {
        Self::default()
    }
}

impl Lines for JsonLines {
    fn line(&mut self, line: &Line<'_>, out: &mut Vec<u8>) {
        let Line { record, channels, decoded, meaning } = line;
        out.push(b'{');
        if !std::mem::replace(&mut self.begun, true) {
            push_schema(SCHEMA, out);
        }
        out.extend_from_slice(b"\"t\":");
        push_decimal(out, record.timestamp.nanos());
        out.extend_from_slice(b",\"channel\":");
        push_json_string(out, channels.name(record.channel));
        out.extend_from_slice(b",\"id\":");
        push_decimal(out, u64::from(record.frame.id().raw()));
        push_kind(&record.frame, out);
        match record.direction {
            Direction::Unknown => {}
            Direction::Rx => out.extend_from_slice(b",\"direction\":\"rx\""),
            Direction::Tx => out.extend_from_slice(b",\"direction\":\"tx\""),
        }
        out.extend_from_slice(b",\"data\":\"");
        push_hex(out, record.data(), None);
        out.extend_from_slice(b"\",\"node\":");
        match decoded.node {
            Some(node) => push_decimal(out, u64::from(node.raw())),
            None => out.extend_from_slice(b"null"),
        }
        out.extend_from_slice(b",\"service\":\"");
        out.extend_from_slice(decoded.service.name().as_bytes());
        out.push(b'"');
        if !matches!(decoded.service, Service::Unknown | Service::ErrorFrame) {
            out.extend_from_slice(b",\"source\":\"");
            out.extend_from_slice(source_name(decoded.source).as_bytes());
            out.push(b'"');
        }
        push_object(line, out);
        if let Some(violation) = decoded.violation {
            push_violation(violation, out);
        }
        push_signals(meaning, out);
        out.extend_from_slice(b",\"text\":");
        push_json_string(out, meaning);
        if let Some(comment) = record.comment() {
            out.extend_from_slice(b",\"comment\":");
            push_json_string(out, comment);
        }
        out.extend_from_slice(b"}\n");
    }
}

/// Appends the schema as a member of the first object.
pub(crate) fn push_schema(schema: &str, out: &mut Vec<u8>) {
    out.extend_from_slice(b"\"schema\":\"");
    out.extend_from_slice(schema.as_bytes());
    out.extend_from_slice(b"\",");
}

/// The JSON name of the source from which the use of a CAN-ID is known.
pub const fn source_name(source: Source) -> &'static str {
    match source {
        Source::Predefined => "predefined",
        Source::Description => "description",
        Source::Trace => "trace",
    }
}

/// Appends the violated rule, with a comma before it.
pub(crate) fn push_violation(violation: Violation, out: &mut Vec<u8>) {
    out.extend_from_slice(b",\"violation\":{\"rule\":\"");
    out.extend_from_slice(violation.name().as_bytes());
    out.extend_from_slice(b"\",\"text\":");
    push_json_string(out, violation);
    out.push(b'}');
}

/// Appends a number. A number that JSON can't express becomes `null`.
pub fn push_number(number: Number, out: &mut Vec<u8>) {
    match number {
        Number::Boolean(value) => out.extend_from_slice(if value { b"true" } else { b"false" }),
        Number::Integer(value) => {
            if value < 0 {
                out.push(b'-');
            }
            push_decimal(out, value.unsigned_abs());
        }
        Number::Unsigned(value) => push_decimal(out, value),
        // A whole number gets a decimal point, too, so that all numbers of a column have one type.
        Number::Real32(value) if value.is_finite() => push_text(out, format_args!("{value:?}")),
        Number::Real64(value) if value.is_finite() => push_text(out, format_args!("{value:?}")),
        Number::Real32(_) | Number::Real64(_) => out.extend_from_slice(b"null"),
    }
}

/// Appends the flags that distinguish a frame from a classical data frame with 11 bits.
fn push_kind(frame: &Frame, out: &mut Vec<u8>) {
    let flags: [(bool, &[u8]); 5] = [
        (frame.id().is_extended() && !frame.is_error(), b",\"extended\":true"),
        (frame.is_remote(), b",\"remote\":true"),
        (frame.is_error(), b",\"error\":true"),
        (frame.is_fd(), b",\"fd\":true"),
        (frame.is_xl(), b",\"xl\":true"),
    ];
    for (_, flag) in flags.iter().filter(|flag| flag.0) {
        out.extend_from_slice(flag);
    }
    if frame.is_remote() {
        out.extend_from_slice(b",\"dlc\":");
        push_decimal(out, frame.len() as u64);
    }
}

fn push_object(line: &Line<'_>, out: &mut Vec<u8>) {
    let Some(object) = line.decoded.object else { return };
    out.extend_from_slice(b",\"index\":");
    push_decimal(out, u64::from(object.index.0));
    out.extend_from_slice(b",\"sub\":");
    push_decimal(out, u64::from(object.sub.0));
    if let Some(name) = line.meaning.object_name() {
        out.extend_from_slice(b",\"object\":");
        push_json_string(out, name);
    }
}

fn push_signals(meaning: &Meaning<'_>, out: &mut Vec<u8>) {
    let mut any = false;
    for signal in meaning.signals() {
        out.extend_from_slice(if any { b",{" } else { b",\"signals\":[{" });
        any = true;
        push_signal(&signal, out);
        out.push(b'}');
    }
    if any {
        out.push(b']');
    }
}

fn push_signal(signal: &SignalValue<'_>, out: &mut Vec<u8>) {
    if let Some(name) = signal.name() {
        out.extend_from_slice(b"\"name\":");
        push_json_string(out, name);
        out.push(b',');
    }
    let object = signal.multiplexer();
    out.extend_from_slice(b"\"index\":");
    push_decimal(out, u64::from(object.index.0));
    out.extend_from_slice(b",\"sub\":");
    push_decimal(out, u64::from(object.sub.0));
    out.extend_from_slice(b",\"raw\":");
    match signal.raw {
        Some(raw) => push_number(raw, out),
        None => out.extend_from_slice(b"null"),
    }
    if let Some((value, unit)) = signal.value() {
        out.extend_from_slice(b",\"value\":");
        push_number(value, out);
        if let Some(unit) = unit {
            out.extend_from_slice(b",\"unit\":");
            push_json_string(out, &unit.symbol);
        }
    }
    if let Some((scaled, unit)) = signal.scaled() {
        out.extend_from_slice(b",\"scaled\":");
        push_number(scaled, out);
        out.extend_from_slice(b",\"scaled_unit\":");
        push_json_string(out, &unit.symbol);
    }
}
