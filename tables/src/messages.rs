//! `messages`: every frame, decoded in its context.

use super::column::{Column, Rows, write, write_str};
use super::decoded_frame::DecodedFrame;
use super::frames::frame_columns;
use canvass_analyzer::network::Decoded;
use canvass_analyzer::wire::sdo::{Request, Response};
use canvass_analyzer::{Meaning, Message, NodeId, Service};
use canvass_reports::decode::source_name;
use canvass_reports::events::StateName;

/// The rows of `messages`.
pub struct Messages;

impl Rows for Messages {
    type Row<'a> = DecodedFrame<'a>;
    const COLUMNS: &'static [Column<Self>] = frame_columns![
        "service" word "the service, by its name in [json.md](json.md)" = |row| Some(row.decoded.service.name());
        "source" word "how the use of the CAN-ID is known: `predefined`, `description`, `trace`" = |row| source(row.decoded);
        "node" u8 "sender of its own messages, server of SDOs, node that an NMT command names" = |row| node(row.decoded);
        "index" u16 "the object that it is about" = |row| row.decoded.object.map(|object| u64::from(object.index.0));
        "sub" u8 "its sub-index" = |row| row.decoded.object.map(|object| u64::from(object.sub.0));
        "object" name "the object's name" = |row, out| write(out, row.meaning().object_name());
        "pdo" name "which PDO: `TPDO 1`" = |row, out| write(out, pdo(&row.decoded.message));
        "abort_code" u32 "of an SDO abort" = |row| abort_code(&row.decoded.message);
        "emcy_code" u16 "the error code of an EMCY" = |row| emcy_code(&row.decoded.message);
        "state" name "the NMT state that a boot-up, heartbeat or guarding message tells" = |row, out| write(out, state(&row.decoded.message));
        "violation" word "the rule of the SDO protocol that it breaks" = |row| row.decoded.violation.map(|broken| broken.name());
        "meaning" text "the frame in words" = |row, out| meaning(&row.meaning(), out);
        "comment" text "what the capture says before the frame" = |row, out| write_str(out, row.record.comment());
    ];
    const ALIKE: &'static [&'static str] = &[
        "capture",
        "channel",
        "can_id",
        "extended",
        "remote",
        "error",
        "fd",
        "xl",
        "service",
        "source",
        "node",
        "index",
        "sub",
        "object",
        "pdo",
        "abort_code",
        "emcy_code",
        "state",
        "violation",
    ];
}

/// Writes the meaning of a frame; frames without text need no formatting.
fn meaning(meaning: &Meaning<'_>, out: &mut String) -> bool {
    match meaning.fixed() {
        Some(text) => write_str(out, Some(text)),
        None => write(out, Some(meaning)),
    }
}

/// The node that a frame concerns.
pub fn node(decoded: &Decoded) -> Option<u64> {
    decoded.node.map(NodeId::raw).map(u64::from)
}

/// The source of the knowledge about the use of the CAN-ID.
fn source(decoded: &Decoded) -> Option<&'static str> {
    (!matches!(decoded.service, Service::Unknown | Service::ErrorFrame)).then(|| source_name(decoded.source))
}

/// The PDO of a frame.
pub const fn pdo(message: &Message) -> Option<canvass_analyzer::PdoNumber> {
    match message {
        Message::Pdo(pdo) | Message::Mpdo(pdo, _) | Message::PdoRequest(pdo) => Some(*pdo),
        _ => None,
    }
}

fn abort_code(message: &Message) -> Option<u64> {
    let abort = match message {
        Message::SdoRequest(Request::Abort(abort)) | Message::SdoResponse(Response::Abort(abort)) => abort,
        _ => return None,
    };
    Some(u64::from(abort.code.0))
}

fn emcy_code(message: &Message) -> Option<u64> {
    match message {
        Message::Emcy(emcy) => emcy.code().map(|code| u64::from(code.0)),
        _ => None,
    }
}

const fn state(message: &Message) -> Option<StateName> {
    match message {
        Message::ErrorControl(told) => Some(StateName(told.state)),
        _ => None,
    }
}
