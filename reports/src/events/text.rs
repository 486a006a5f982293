//! One aligned line for each event: time, channel, node, kind, description.

use super::{Events, Scene, StateName, UseName, outcome_name};
use crate::color::{Color, push_begin, push_end};
use crate::decode::{TimeStyle, push_comment, push_node};
use crate::push::{pad, push_text, push_visible};
use crate::time::Clock;
use canvass_analyzer::network::sdo::{Direction, Outcome, Transfer};
use canvass_analyzer::network::{Cause, Emergency, Event, Exchange, Move, Source, StateChange};
use canvass_analyzer::{EmcyText, Multiplexer, NodeId, PdoNumber, TransferText};
use canvass_traces::Duration;

/// Events as text.
pub struct TextEvents {
    clock: Clock,
    color: bool,
    channel_width: usize,
}

const KIND_WIDTH: usize = 8;

impl TextEvents {
    /// A rendering with this style of time, with or without colours.
    pub const fn new(time: TimeStyle, color: bool) -> Self {
        Self { clock: Clock::new(time), color, channel_width: 4 }
    }

    fn begin(&mut self, scene: &Scene<'_>, node: Option<NodeId>, kind: &str, color: Option<Color>, out: &mut Vec<u8>) {
        self.clock.push(scene.time, out);
        out.extend_from_slice(b"  ");
        let start = out.len();
        push_visible(out, scene.channel);
        self.channel_width = self.channel_width.max(out.len() - start);
        pad(out, start, self.channel_width);
        out.extend_from_slice(b"  ");
        push_node(node, out);
        out.extend_from_slice(b"  ");
        let start = out.len();
        out.extend_from_slice(kind.as_bytes());
        pad(out, start, KIND_WIDTH);
        out.push(b' ');
        push_begin(color.filter(|_| self.color), out);
    }

    fn end(&self, color: Option<Color>, out: &mut Vec<u8>) {
        push_end(color.filter(|_| self.color), out);
        out.push(b'\n');
    }

    fn transfer(&mut self, scene: &Scene<'_>, server: NodeId, transfer: &Transfer, left: bool, out: &mut Vec<u8>) {
        let bad = transfer.violation.is_some() || transfer.outcome != Outcome::Complete;
        let color = bad.then_some(Color::Red);
        self.begin(scene, Some(server), "sdo", color, out);
        push_transfer(&TransferText::new(scene.bus, server, transfer), transfer, left, out);
        self.end(color, out);
    }
}

impl Events for TextEvents {
    fn comment(&mut self, _: &Scene<'_>, comment: &str, out: &mut Vec<u8>) {
        push_comment(comment, out);
    }

    fn event(&mut self, scene: &Scene<'_>, event: &Event, out: &mut Vec<u8>) {
        if let Some((server, transfer)) = scene.transfer(event) {
            return self.transfer(scene, server, transfer, matches!(event, Event::TransferLeft(_)), out);
        }
        let color = color(event);
        self.begin(scene, scene.node(event), kind(scene, event), color, out);
        match *event {
            Event::TransferEnded | Event::TransferLeft(_) => push_text(out, "a transfer that is not known any more"),
            Event::StateChanged(_, change) => push_change(change, out),
            Event::Emergency(node, emergency) => push_emergency(scene, node, emergency, out),
            Event::LayerSetting(exchange) => push_exchange(scene, exchange, out),
            Event::NodeIdChanged { from, to, object } => push_node_id(from, to, object, out),
            Event::BitRateChanged { node, bit_rate, delay } => push_bit_rate(node, bit_rate, delay, out),
            Event::Recognised(node) => push_recognition(scene, node, out),
            Event::CobIdMoved(moved) => push_move(moved, out),
            Event::MappingChanged(node, pdo) => push_mapping(scene, node, pdo, out),
        }
        self.end(color, out);
    }

    fn open_transfer(&mut self, scene: &Scene<'_>, server: NodeId, transfer: &Transfer, out: &mut Vec<u8>) {
        self.transfer(scene, server, transfer, false, out);
    }
}

fn kind(scene: &Scene<'_>, event: &Event) -> &'static str {
    match event {
        Event::TransferEnded | Event::TransferLeft(_) => "sdo",
        Event::StateChanged(_, StateChange { cause: Cause::BootUp, .. }) => "boot-up",
        Event::StateChanged(..) => "state",
        Event::Emergency(..) => "emcy",
        Event::LayerSetting(_) => scene.layer_setting(),
        Event::NodeIdChanged { .. } => "node-id",
        Event::BitRateChanged { .. } => "bit-rate",
        Event::Recognised(_) => "device",
        Event::CobIdMoved(_) => "cob-id",
        Event::MappingChanged(..) => "mapping",
    }
}

/// The colour of an event, as for frames: red for errors, yellow for changes of state, cyan for commands.
fn color(event: &Event) -> Option<Color> {
    match event {
        Event::Emergency(_, emergency) if emergency.emcy.code().is_none_or(|code| !code.is_reset()) => Some(Color::Red),
        Event::StateChanged(..) => Some(Color::Yellow),
        Event::LayerSetting(_) | Event::NodeIdChanged { .. } | Event::BitRateChanged { .. } => Some(Color::Cyan),
        _ => None,
    }
}

fn push_transfer(text: &TransferText<'_>, transfer: &Transfer, left: bool, out: &mut Vec<u8>) {
    let verb = match transfer.direction {
        Direction::Upload => "read",
        Direction::Download => "write",
    };
    push_text(out, format_args!("{verb} {}", text.object()));
    if transfer.length() > 0 {
        push_text(out, format_args!(" = {}", text.value()));
    }
    push_text(out, format_args!(": {}", transfer.mode));
    if transfer.length() > 0 {
        push_text(out, format_args!(", {} byte{}", transfer.length(), plural(transfer.length())));
    }
    if transfer.segments > 0 {
        push_text(out, format_args!(" in {} segment{}", transfer.segments, plural(transfer.segments.into())));
    }
    push_text(out, format_args!(", {}", transfer.duration()));
    match transfer.outcome {
        Outcome::Complete => {}
        Outcome::Aborted(side, code) => push_text(out, format_args!(", aborted by {side}: {code}")),
        Outcome::Superseded => push_text(out, ", given up: the client began another one"),
        Outcome::Open if left => push_text(out, ", given up: the node started anew"),
        other => push_text(out, format_args!(", {} at the end of the capture", outcome_name(other, left))),
    }
    if let Some(violation) = transfer.violation {
        push_text(out, format_args!(" [violation: {violation}]"));
    }
}

const fn plural(n: u64) -> &'static str {
    if n == 1 { "" } else { "s" }
}

fn push_change(change: StateChange, out: &mut Vec<u8>) {
    let (to, from) = (StateName(change.to), change.from.map(StateName));
    match (change.cause, from) {
        (Cause::BootUp, Some(from)) => return push_text(out, format_args!("boot-up, was {from}")),
        (Cause::BootUp, None) => return push_text(out, "boot-up"),
        (_, Some(from)) => push_text(out, format_args!("{from} -> {to}")),
        (_, None) => push_text(out, to),
    }
    push_text(out, if change.cause == Cause::Command { ", as commanded" } else { ", as its error control shows" });
}

fn push_emergency(scene: &Scene<'_>, node: NodeId, emergency: Emergency, out: &mut Vec<u8>) {
    let reset = emergency.emcy.code().is_some_and(|code| code.is_reset());
    push_text(out, if reset { "gone: " } else { "raised: " });
    push_text(out, EmcyText::of(&emergency.emcy, node, scene.bus));
    if let Some(since) = emergency.since.filter(|_| reset) {
        push_text(out, format_args!(", after {}", scene.time - since));
    }
}

fn push_exchange(scene: &Scene<'_>, exchange: Exchange, out: &mut Vec<u8>) {
    match exchange {
        Exchange::Request { .. } => push_text(out, "-> "),
        Exchange::Response(_) | Exchange::Unasked => push_text(out, "<- "),
    }
    if let Some(meaning) = scene.meaning() {
        push_text(out, meaning);
    }
    match exchange {
        Exchange::Request { unanswered: true } => push_text(out, " [the request before was not answered]"),
        Exchange::Request { unanswered: false } => {}
        Exchange::Response(delay) => push_text(out, format_args!(", after {delay}")),
        Exchange::Unasked => push_text(out, " [nothing was asked]"),
    }
}

fn push_move(moved: Move, out: &mut Vec<u8>) {
    let used = UseName(moved.used);
    match (moved.from, moved.to) {
        (Some(from), Some(to)) => push_text(out, format_args!("{used}: {from:03X}h -> {to:03X}h")),
        (None, Some(to)) => push_text(out, format_args!("{used}: now {to:03X}h")),
        (Some(from), None) => push_text(out, format_args!("{used}: {from:03X}h no more")),
        (None, None) => push_text(out, used),
    }
    push_text(
        out,
        match moved.source {
            Source::Predefined => ", as predefined",
            Source::Description => ", by the description",
            Source::Trace => ", by SDO traffic",
        },
    );
}

fn push_node_id(from: Option<NodeId>, to: NodeId, object: Option<Multiplexer>, out: &mut Vec<u8>) {
    match from {
        Some(from) => push_text(out, format_args!("node {from} has become node {to}")),
        None => push_text(out, format_args!("a device has become node {to}")),
    }
    match object {
        Some(object) => push_text(out, format_args!(", as written to {object}")),
        None => push_text(out, ", as set by layer setting"),
    }
}

fn push_bit_rate(node: Option<NodeId>, bit_rate: Option<u32>, delay: Duration, out: &mut Vec<u8>) {
    push_text(out, if node.is_some() { "starts with " } else { "all change to " });
    match bit_rate {
        Some(bit_rate) => push_text(out, format_args!("{} kbit/s", bit_rate / 1000)),
        None => push_text(out, "a bit rate that is not known"),
    }
    if node.is_none() {
        push_text(out, format_args!(", {delay} of silence"));
    }
}

fn push_recognition(scene: &Scene<'_>, node: NodeId, out: &mut Vec<u8>) {
    let Some(recognition) = scene.bus.node(node).and_then(|node| node.recognition.as_ref()) else { return };
    push_text(out, format_args!("recognised as {}", recognition.model));
    for (n, object) in recognition.by.iter().enumerate() {
        push_text(out, format_args!("{}{object}", if n == 0 { " by " } else { ", " }));
    }
    for other in &recognition.or {
        push_text(out, format_args!(", or {other}"));
    }
}

fn push_mapping(scene: &Scene<'_>, node: NodeId, pdo: PdoNumber, out: &mut Vec<u8>) {
    push_text(out, pdo);
    match scene.bus.node(node).and_then(|known| known.mapping(node, pdo)) {
        None => push_text(out, ": no mapping"),
        Some(entries) => {
            for (n, entry) in entries.iter().enumerate() {
                let object: Multiplexer = entry.object();
                push_text(out, if n == 0 { ": " } else { ", " });
                push_text(out, format_args!("{object} ({} bits)", entry.bits()));
            }
        }
    }
}
