//! `events`: events caused by frames: whole SDO transfers, states, errors, layer setting, and learned COB-IDs and
//! mappings.

use super::column::{Column, Rows, write, write_str};
use crate::columns;
use canvass_analyzer::network::sdo::{Outcome, Side, Transfer};
use canvass_analyzer::network::{Emergency, Event, Exchange, Move, StateChange};
use canvass_analyzer::{EmcyText, Multiplexer, NodeId, TransferText};
use canvass_reports::decode::source_name;
use canvass_reports::events::{Events as _, JsonEvents, Scene, StateName, UseName, outcome_name};
use canvass_traces::Timestamp;

/// The rows of `events`.
pub struct Events;

/// An event of a capture.
pub struct EventRow<'a> {
    /// The name of the capture.
    pub capture: &'a str,
    /// The frame that caused the event, and its bus.
    pub scene: &'a Scene<'a>,
    /// The event, open transfer or comment.
    pub what: What<'a>,
}

/// An event, an open transfer or a comment.
#[derive(Clone, Copy)]
pub enum What<'a> {
    /// An event, with the transfer that it ended or left open.
    Event(&'a Event, Option<(NodeId, &'a Transfer)>),
    /// A transfer that had not ended at the end of the capture.
    Open(NodeId, &'a Transfer),
    /// A comment of the capture before the next event.
    Comment(&'a str),
}

impl Rows for Events {
    type Row<'a> = EventRow<'a>;
    const COLUMNS: &'static [Column<Self>] = columns![Self:
        "capture" name "the file" = |row, out| write_str(out, Some(row.capture));
        "t" time "when its last frame was seen" = |row| Some(row.scene.time);
        "channel" name "the channel's name" = |row, out| write_str(out, Some(row.scene.channel));
        "event" word "`sdo`, `state`, `boot-up`, `emcy`, `lss`, `lmt`, `node-id`, `bit-rate`, `device`, `cob-id`, `mapping`, `comment`" = |row| Some(row.kind());
        "node" u8 "the node that it is about" = |row| row.node().map(NodeId::raw).map(u64::from);
        "index" u16 "the object, of `sdo` and of a `node-id` that an object has set" = |row| row.multiplexer().map(|object| u64::from(object.index.0));
        "sub" u8 "its sub-index" = |row| row.multiplexer().map(|object| u64::from(object.sub.0));
        "object" name "the object's name" = |row, out| write(out, row.transfer_text().and_then(|text| text.name()));
        "direction" word "of `sdo`: `upload`, `download`" = |row| row.transfer().map(|(_, transfer)| transfer.direction.name());
        "mode" word "of `sdo`: `expedited`, `segmented`, `block`" = |row| row.transfer().map(|(_, transfer)| transfer.mode.name());
        "outcome" word "of `sdo`: `complete`, `aborted`, `superseded`, `reset`, `open`" = |row| row.outcome();
        "started" time "of `sdo`: when its first frame was seen" = |row| row.transfer().map(|(_, transfer)| transfer.started);
        "duration_ns" i64 "of `sdo` its duration; of a cleared `emcy` the time since the first error that was not cleared before" = |row| row.duration();
        "bytes" u64 "of `sdo`: how many bytes were transferred" = |row| row.transfer().map(|(_, transfer)| transfer.length());
        "segments" u32 "of `sdo`" = |row| row.transfer().map(|(_, transfer)| u64::from(transfer.segments));
        "announced" u32 "of `sdo`: how many bytes were announced" = |row| row.transfer().and_then(|(_, transfer)| transfer.announced).map(u64::from);
        "data" bytes "of `sdo` the first 64 KiB of the value; of `lss` and `lmt` the message" = |row| row.data();
        "value" text "of `sdo`: the value in words" = |row, out| row.write_value(out);
        "abort_code" u32 "of an aborted `sdo`" = |row| row.abort().map(|(_, code)| u64::from(code.0));
        "abort_by" word "`client` or `server`" = |row| row.abort().map(|(side, _)| side.name());
        "violation" word "of `sdo`: the first rule of the protocol that it broke" = |row| row.transfer().and_then(|(_, transfer)| transfer.violation).map(|broken| broken.name());
        "from_state" name "of `state` and `boot-up`: the state before" = |row, out| write(out, row.change().and_then(|change| change.from).map(StateName));
        "to_state" name "the state from then on" = |row, out| write(out, row.change().map(|change| StateName(change.to)));
        "cause" word "how that is known: `command`, `boot-up`, `error-control`" = |row| row.change().map(|change| change.cause.name());
        "emcy_state" word "of `emcy`: `raised`, `cleared`" = |row| row.emergency().map(|emergency| if is_cleared(&emergency) { "cleared" } else { "raised" });
        "emcy_code" u16 "the error code" = |row| row.emergency().and_then(|emergency| emergency.emcy.code()).map(|code| u64::from(code.0));
        "emcy_register" u8 "the error register" = |row| row.emergency().and_then(|emergency| emergency.emcy.register()).map(|register| u64::from(register.0));
        "manufacturer" bytes "the manufacturer's part of an EMCY" = |row| row.manufacturer();
        "role" word "of `lss` and `lmt`: `request`, `response`" = |row| row.exchange().map(|exchange| if matches!(exchange, Exchange::Request { .. }) { "request" } else { "response" });
        "previous_unanswered" flag "whether the request before should have been answered and was not" = |row| row.previous_unanswered();
        "delay_ns" i64 "of a response the time since the request; of `bit-rate` the silence before and after" = |row| row.delay();
        "from_node" u8 "of `node-id`: the node-ID before" = |row| row.node_ids().and_then(|(from, _)| from).map(|from| u64::from(from.raw()));
        "to_node" u8 "the node-ID from then on" = |row| row.node_ids().map(|(_, to)| u64::from(to.raw()));
        "bit_rate" u32 "of `bit-rate`, in bit/s" = |row| row.bit_rate().map(u64::from);
        "model" name "of `device`: the built-in model or description that the node was recognised as" = |row, out| row.write_model(out);
        "used_for" name "of `cob-id`: the use that moved: `TPDO 1`, `SDO request`" = |row, out| write(out, row.moved().map(|moved| UseName(moved.used)));
        "from_can_id" u16 "the CAN-ID before" = |row| row.moved().and_then(|moved| moved.from).map(u64::from);
        "to_can_id" u16 "the CAN-ID from then on" = |row| row.moved().and_then(|moved| moved.to).map(u64::from);
        "source" word "how that is known: `predefined`, `description`, `trace`" = |row| row.moved().map(|moved| source_name(moved.source));
        "pdo" name "of `mapping`: `TPDO 1`" = |row, out| match row.event() {
            Some(Event::MappingChanged(_, pdo)) => write(out, Some(pdo)),
            _ => false,
        };
        "text" text "in words: of `emcy`, `lss`, `lmt`, `comment` and of an abort" = |row, out| row.write_text(out);
        "detail" text "the whole event as JSON, as `canvass decode --events --format json` writes it" = |row, out| row.write_detail(out);
    ];
}

fn is_cleared(emergency: &Emergency) -> bool {
    emergency.emcy.code().is_some_and(|code| code.is_reset())
}

impl<'a> EventRow<'a> {
    const fn event(&self) -> Option<&'a Event> {
        match self.what {
            What::Event(event, _) => Some(event),
            _ => None,
        }
    }

    fn kind(&self) -> &'static str {
        match self.what {
            What::Event(event, _) => self.scene.kind(event),
            What::Open(..) => "sdo",
            What::Comment(_) => "comment",
        }
    }

    fn node(&self) -> Option<NodeId> {
        match self.what {
            What::Event(_, Some((server, _))) | What::Open(server, _) => Some(server),
            What::Event(event, None) => self.scene.node(event),
            What::Comment(_) => None,
        }
    }

    const fn transfer(&self) -> Option<(NodeId, &'a Transfer)> {
        match self.what {
            What::Event(_, transfer) => transfer,
            What::Open(server, transfer) => Some((server, transfer)),
            What::Comment(_) => None,
        }
    }

    fn transfer_text(&self) -> Option<TransferText<'a>> {
        self.transfer().map(|(server, transfer)| TransferText::new(self.scene.bus, server, transfer))
    }

    fn multiplexer(&self) -> Option<Multiplexer> {
        match self.event() {
            Some(Event::NodeIdChanged { object, .. }) => *object,
            _ => self.transfer().map(|(_, transfer)| transfer.multiplexer),
        }
    }

    fn outcome(&self) -> Option<&'static str> {
        let left = matches!(self.what, What::Event(Event::TransferLeft(_), _));
        self.transfer().map(|(_, transfer)| outcome_name(transfer.outcome, left))
    }

    fn abort(&self) -> Option<(Side, canvass_analyzer::wire::sdo::AbortCode)> {
        match self.transfer()?.1.outcome {
            Outcome::Aborted(side, code) => Some((side, code)),
            _ => None,
        }
    }

    fn duration(&self) -> Option<i64> {
        let since = |from: Timestamp| self.scene.time.since(from).nanos();
        let nanos = match (self.transfer(), self.emergency()) {
            (Some((_, transfer)), _) => transfer.duration().nanos(),
            (None, Some(emergency)) if is_cleared(&emergency) => since(emergency.since?),
            _ => return None,
        };
        i64::try_from(nanos).ok()
    }

    fn data(&self) -> Option<&[u8]> {
        match (self.transfer(), self.exchange()) {
            (Some((_, transfer)), _) => Some(transfer.data()),
            (None, Some(_)) => self.scene.frame.map(|(record, _)| record.data()),
            _ => None,
        }
    }

    fn write_value(&self, out: &mut String) -> bool {
        let has_value = self.transfer().is_some_and(|(_, transfer)| transfer.length() > 0);
        write(out, self.transfer_text().filter(|_| has_value).as_ref().map(TransferText::value))
    }

    const fn change(&self) -> Option<StateChange> {
        match self.event() {
            Some(Event::StateChanged(_, change)) => Some(*change),
            _ => None,
        }
    }

    const fn emergency(&self) -> Option<Emergency> {
        match self.event() {
            Some(Event::Emergency(_, emergency)) => Some(*emergency),
            _ => None,
        }
    }

    fn manufacturer(&self) -> Option<&[u8]> {
        match self.event() {
            Some(Event::Emergency(_, emergency)) => Some(emergency.emcy.manufacturer()),
            _ => None,
        }
    }

    const fn exchange(&self) -> Option<Exchange> {
        match self.event() {
            Some(Event::LayerSetting(exchange)) => Some(*exchange),
            _ => None,
        }
    }

    const fn previous_unanswered(&self) -> Option<bool> {
        match self.exchange() {
            Some(Exchange::Request { unanswered }) => Some(unanswered),
            _ => None,
        }
    }

    fn delay(&self) -> Option<i64> {
        let delay = match (self.exchange(), self.event()) {
            (Some(Exchange::Response(delay)), _) => delay,
            (None, Some(Event::BitRateChanged { delay, .. })) => *delay,
            _ => return None,
        };
        i64::try_from(delay.nanos()).ok()
    }

    const fn node_ids(&self) -> Option<(Option<NodeId>, NodeId)> {
        match self.event() {
            Some(Event::NodeIdChanged { from, to, .. }) => Some((*from, *to)),
            _ => None,
        }
    }

    const fn bit_rate(&self) -> Option<u32> {
        match self.event() {
            Some(Event::BitRateChanged { bit_rate, .. }) => *bit_rate,
            _ => None,
        }
    }

    fn write_model(&self, out: &mut String) -> bool {
        let Some(Event::Recognised(id)) = self.event() else { return false };
        let recognition = self.scene.bus.node(*id).and_then(|node| node.recognition.as_ref());
        write_str(out, recognition.map(|recognition| &*recognition.model))
    }

    const fn moved(&self) -> Option<Move> {
        match self.event() {
            Some(Event::CobIdMoved(moved)) => Some(*moved),
            _ => None,
        }
    }

    fn write_text(&self, out: &mut String) -> bool {
        if let Some((_, code)) = self.abort() {
            return write_str(out, Some(code.text()));
        }
        match (self.what, self.event()) {
            (What::Comment(text), _) => write_str(out, Some(text)),
            (_, Some(Event::Emergency(node, emergency))) => {
                write(out, Some(EmcyText::of(&emergency.emcy, *node, self.scene.bus)))
            }
            (_, Some(Event::LayerSetting(_))) => write(out, self.scene.meaning()),
            _ => false,
        }
    }

    fn write_detail(&self, out: &mut String) -> bool {
        let (mut json, mut line) = (JsonEvents::without_schema(), Vec::new());
        match self.what {
            What::Event(event, _) => json.event(self.scene, event, &mut line),
            What::Open(server, transfer) => json.open_transfer(self.scene, server, transfer, &mut line),
            What::Comment(text) => json.comment(self.scene, text, &mut line),
        }
        out.push_str(String::from_utf8_lossy(line.trim_ascii_end()).as_ref());
        true
    }
}
