//! JSON Lines: one object per event, as `docs/json.md` describes it.

use super::{Events, Scene, StateName, UseName, outcome_name};
use crate::decode::{push_schema, push_violation, source_name};
use crate::push::{push_decimal, push_hex, push_json_string, push_text};
use canvass_analyzer::network::sdo::{Outcome, Transfer};
use canvass_analyzer::network::{Emergency, Event, Exchange, Move, StateChange};
use canvass_analyzer::{EmcyText, NodeId, PdoNumber, TransferText};

/// Events as JSON.
#[derive(Default)]
pub struct JsonEvents {
    begun: bool,
}

/// The name and version of the contract.
const SCHEMA: &str = "canvass/events/1";

impl JsonEvents {
    /// A rendering that has written nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A rendering of single events without the name of the schema.
    pub const fn without_schema() -> Self {
        Self { begun: true }
    }

    fn begin(&mut self, scene: &Scene<'_>, kind: &str, node: Option<NodeId>, out: &mut Vec<u8>) {
        out.push(b'{');
        if !std::mem::replace(&mut self.begun, true) {
            push_schema(SCHEMA, out);
        }
        push_text(out, format_args!("\"event\":\"{kind}\",\"t\":{}", scene.time.nanos()));
        out.extend_from_slice(b",\"channel\":");
        push_json_string(out, scene.channel);
        push_optional(out, "node", node.map(|node| u64::from(node.raw())));
    }

    fn transfer(&mut self, scene: &Scene<'_>, server: NodeId, transfer: &Transfer, left: bool, out: &mut Vec<u8>) {
        self.begin(scene, "sdo", Some(server), out);
        let text = TransferText::new(scene.bus, server, transfer);
        let object = transfer.multiplexer;
        push_text(out, format_args!(",\"index\":{},\"sub\":{}", object.index.0, object.sub.0));
        if let Some(name) = text.name() {
            out.extend_from_slice(b",\"object\":");
            push_json_string(out, name);
        }
        push_text(out, format_args!(",\"direction\":\"{}\",\"mode\":\"{}\"", transfer.direction, transfer.mode));
        let (outcome, started) = (outcome_name(transfer.outcome, left), transfer.started.nanos());
        push_text(out, format_args!(",\"outcome\":\"{outcome}\",\"started\":{started}"));
        push_text(out, format_args!(",\"duration_ns\":{}", transfer.duration().nanos()));
        push_text(out, format_args!(",\"bytes\":{},\"segments\":{}", transfer.length(), transfer.segments));
        push_optional(out, "announced", transfer.announced.map(u64::from));
        out.extend_from_slice(b",\"data\":\"");
        push_hex(out, transfer.data(), None);
        out.extend_from_slice(b"\",\"value\":");
        match transfer.length() {
            0 => out.extend_from_slice(b"null"),
            _ => push_json_string(out, text.value()),
        }
        if let Outcome::Aborted(side, code) = transfer.outcome {
            push_text(out, format_args!(",\"abort\":{{\"code\":{},\"by\":\"{side}\",\"text\":", code.0));
            push_json_string(out, code.text());
            out.push(b'}');
        }
        if let Some(violation) = transfer.violation {
            push_violation(violation, out);
        }
        out.extend_from_slice(b"}\n");
    }
}

impl Events for JsonEvents {
    fn comment(&mut self, scene: &Scene<'_>, comment: &str, out: &mut Vec<u8>) {
        self.begin(scene, "comment", None, out);
        out.extend_from_slice(b",\"text\":");
        push_json_string(out, comment);
        out.extend_from_slice(b"}\n");
    }

    fn event(&mut self, scene: &Scene<'_>, event: &Event, out: &mut Vec<u8>) {
        if let Some((server, transfer)) = scene.transfer(event) {
            return self.transfer(scene, server, transfer, matches!(event, Event::TransferLeft(_)), out);
        }
        // A transfer whose channel is not known has no content to report.
        if matches!(event, Event::TransferEnded | Event::TransferLeft(_)) {
            return;
        }
        self.begin(scene, scene.kind(event), scene.node(event), out);
        match *event {
            Event::TransferEnded | Event::TransferLeft(_) => {}
            Event::StateChanged(_, change) => push_change(change, out),
            Event::Emergency(source, emergency) => push_emergency(scene, source, emergency, out),
            Event::LayerSetting(exchange) => push_exchange(scene, exchange, out),
            Event::NodeIdChanged { from, to, object } => {
                push_optional(out, "from", from.map(|from| u64::from(from.raw())));
                push_text(out, format_args!(",\"to\":{to}"));
                if let Some(object) = object {
                    push_text(out, format_args!(",\"index\":{},\"sub\":{}", object.index.0, object.sub.0));
                }
            }
            Event::Recognised(id) => push_recognition(scene, id, out),
            Event::BitRateChanged { bit_rate, delay, .. } => {
                push_optional(out, "bit_rate", bit_rate.map(u64::from));
                push_text(out, format_args!(",\"delay_ns\":{}", delay.nanos()));
            }
            Event::CobIdMoved(moved) => push_move(moved, out),
            Event::MappingChanged(id, pdo) => push_mapping(scene, id, pdo, out),
        }
        out.extend_from_slice(b"}\n");
    }

    fn open_transfer(&mut self, scene: &Scene<'_>, server: NodeId, transfer: &Transfer, out: &mut Vec<u8>) {
        self.transfer(scene, server, transfer, false, out);
    }
}

/// Appends a number, or `null`.
fn push_optional(out: &mut Vec<u8>, key: &str, number: Option<u64>) {
    push_text(out, format_args!(",\"{key}\":"));
    match number {
        Some(number) => push_decimal(out, number),
        None => out.extend_from_slice(b"null"),
    }
}

fn push_change(change: StateChange, out: &mut Vec<u8>) {
    out.extend_from_slice(b",\"from\":");
    match change.from {
        Some(from) => push_json_string(out, StateName(from)),
        None => out.extend_from_slice(b"null"),
    }
    out.extend_from_slice(b",\"to\":");
    push_json_string(out, StateName(change.to));
    push_text(out, format_args!(",\"cause\":\"{}\"", change.cause.name()));
}

fn push_emergency(scene: &Scene<'_>, node: NodeId, emergency: Emergency, out: &mut Vec<u8>) {
    let emcy = &emergency.emcy;
    let cleared = emcy.code().is_some_and(|code| code.is_reset());
    push_text(out, format_args!(",\"state\":\"{}\"", if cleared { "cleared" } else { "raised" }));
    push_optional(out, "code", emcy.code().map(|code| u64::from(code.0)));
    push_optional(out, "register", emcy.register().map(|register| u64::from(register.0)));
    out.extend_from_slice(b",\"manufacturer\":\"");
    push_hex(out, emcy.manufacturer(), None);
    out.push(b'"');
    if cleared {
        push_optional(out, "duration_ns", emergency.since.map(|since| (scene.time - since).nanos()));
    }
    out.extend_from_slice(b",\"text\":");
    push_json_string(out, EmcyText::of(emcy, node, scene.bus));
}

fn push_exchange(scene: &Scene<'_>, exchange: Exchange, out: &mut Vec<u8>) {
    match exchange {
        Exchange::Request { unanswered } => {
            push_text(out, format_args!(",\"role\":\"request\",\"previous_unanswered\":{unanswered}"));
        }
        Exchange::Response(delay) => {
            push_text(out, format_args!(",\"role\":\"response\",\"delay_ns\":{}", delay.nanos()));
        }
        Exchange::Unasked => out.extend_from_slice(b",\"role\":\"response\",\"delay_ns\":null"),
    }
    if let Some((record, _)) = scene.frame {
        out.extend_from_slice(b",\"data\":\"");
        push_hex(out, record.data(), None);
        out.push(b'"');
    }
    if let Some(meaning) = scene.meaning() {
        out.extend_from_slice(b",\"text\":");
        push_json_string(out, meaning);
    }
}

fn push_recognition(scene: &Scene<'_>, node: NodeId, out: &mut Vec<u8>) {
    let Some(recognition) = scene.bus.node(node).and_then(|node| node.recognition.as_ref()) else { return };
    out.extend_from_slice(b",\"model\":");
    push_json_string(out, &recognition.model);
    out.extend_from_slice(b",\"or\":[");
    for (n, other) in recognition.or.iter().enumerate() {
        out.extend_from_slice(if n == 0 { b"" } else { b"," });
        push_json_string(out, other);
    }
    out.extend_from_slice(b"],\"by\":[");
    for (n, object) in recognition.by.iter().enumerate() {
        let (comma, index, sub) = (if n == 0 { "" } else { "," }, object.index.0, object.sub.0);
        push_text(out, format_args!("{comma}{{\"index\":{index},\"sub\":{sub}}}"));
    }
    out.push(b']');
}

fn push_move(moved: Move, out: &mut Vec<u8>) {
    push_text(out, format_args!(",\"use\":\"{}\"", UseName(moved.used)));
    push_optional(out, "from", moved.from.map(u64::from));
    push_optional(out, "to", moved.to.map(u64::from));
    push_text(out, format_args!(",\"source\":\"{}\"", source_name(moved.source)));
}

fn push_mapping(scene: &Scene<'_>, node: NodeId, pdo: PdoNumber, out: &mut Vec<u8>) {
    push_text(out, format_args!(",\"pdo\":\"{pdo}\",\"entries\":"));
    let Some(entries) = scene.bus.node(node).and_then(|known| known.mapping(node, pdo)) else {
        return out.extend_from_slice(b"null");
    };
    out.push(b'[');
    for (n, entry) in entries.iter().enumerate() {
        let (object, comma) = (entry.object(), if n == 0 { "" } else { "," });
        let (index, sub, bits) = (object.index.0, object.sub.0, entry.bits());
        push_text(out, format_args!("{comma}{{\"index\":{index},\"sub\":{sub},\"bits\":{bits}}}"));
    }
    out.push(b']');
}
