//! Events that frames caused: whole SDO transfers, states, errors, layer setting, and new knowledge of the network.

mod json;
mod text;

pub use json::JsonEvents;
pub use text::TextEvents;

use canvass_analyzer::network::sdo::{Outcome, Transfer};
use canvass_analyzer::network::{Bus, Cause, Event, Use};
use canvass_analyzer::wire::error_control::State;
use canvass_analyzer::wire::srdo::Half;
use canvass_analyzer::{Meaning, NodeId, network::Decoded};
use canvass_traces::{Record, Timestamp};
use std::fmt;

/// The frame that caused an event, and its bus.
pub struct Scene<'a> {
    /// The time of the frame.
    pub time: Timestamp,
    /// The name of the frame's channel.
    pub channel: &'a str,
    /// The state of the bus after the frame.
    pub bus: &'a Bus,
    /// The frame and its decoding. `None` at the end of a capture.
    pub frame: Option<(&'a Record, &'a Decoded)>,
}

/// A rendering of events.
pub trait Events {
    /// Appends an event to `out`.
    fn event(&mut self, scene: &Scene<'_>, event: &Event, out: &mut Vec<u8>);

    /// Appends a comment of the capture before the next shown event.
    fn comment(&mut self, scene: &Scene<'_>, comment: &str, out: &mut Vec<u8>);

    /// Appends a transfer that had not ended at the end of the capture.
    fn open_transfer(&mut self, scene: &Scene<'_>, server: NodeId, transfer: &Transfer, out: &mut Vec<u8>);
}

impl<'a> Scene<'a> {
    /// The node that an event is about.
    pub fn node(&self, event: &Event) -> Option<NodeId> {
        match *event {
            Event::TransferEnded | Event::LayerSetting(_) => self.frame.and_then(|(_, decoded)| decoded.node),
            Event::TransferLeft(channel) => self.bus.server(channel),
            Event::StateChanged(node, _) | Event::Emergency(node, _) | Event::MappingChanged(node, _) => Some(node),
            Event::NodeIdChanged { to, .. } => Some(to),
            Event::BitRateChanged { node, .. } => node,
            Event::Recognised(node) => Some(node),
            Event::CobIdMoved(moved) => match moved.used {
                Use::Emcy(node) | Use::Pdo(node, _) | Use::Srdo(node, ..) | Use::ErrorControl(node) => Some(node),
                Use::SdoRequest(channel) | Use::SdoResponse(channel) => self.bus.server(channel),
                _ => self.frame.and_then(|(_, decoded)| decoded.node),
            },
        }
    }

    /// The kind of the event in JSON.
    pub fn kind(&self, event: &Event) -> &'static str {
        match event {
            Event::TransferEnded | Event::TransferLeft(_) => "sdo",
            Event::StateChanged(_, change) if change.cause == Cause::BootUp => "boot-up",
            Event::StateChanged(..) => "state",
            Event::Emergency(..) => "emcy",
            Event::LayerSetting(_) => self.layer_setting(),
            Event::NodeIdChanged { .. } => "node-id",
            Event::BitRateChanged { .. } => "bit-rate",
            Event::CobIdMoved(_) => "cob-id",
            Event::Recognised(_) => "device",
            Event::MappingChanged(..) => "mapping",
        }
    }

    /// The transfer of an event, with its server.
    pub fn transfer(&self, event: &Event) -> Option<(NodeId, &'a Transfer)> {
        let (channel, transfer) = match *event {
            Event::TransferEnded => {
                let channel = self.frame?.1.channel?;
                (channel, self.bus.transfer(channel)?)
            }
            Event::TransferLeft(channel) => (channel, self.bus.left_transfer(channel)?),
            _ => return None,
        };
        Some((self.bus.server(channel)?, transfer))
    }

    /// The meaning of the frame.
    pub fn meaning(&self) -> Option<Meaning<'a>> {
        self.frame.map(|(record, decoded)| Meaning::new(record, decoded, self.bus))
    }

    /// The service of the frame: `lss` or `lmt`.
    pub fn layer_setting(&self) -> &'static str {
        self.frame.map_or("lss", |(_, decoded)| decoded.service.name())
    }
}

/// The outcome of a transfer. A transfer that was left open was ended by a reset of its server.
pub const fn outcome_name(outcome: Outcome, left: bool) -> &'static str {
    match outcome {
        Outcome::Complete => "complete",
        Outcome::Aborted(..) => "aborted",
        Outcome::Superseded => "superseded",
        Outcome::Open if left => "reset",
        Outcome::Open => "open",
    }
}

/// The name of an NMT state. After a reset command a node is initialising until its boot-up message.
pub struct StateName(pub State);

impl fmt::Display for StateName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            State::BOOT_UP => f.write_str("initialisation"),
            other => write!(f, "{other}"),
        }
    }
}

/// The name of the use of a CAN-ID: `TPDO 1`, `SDO request`.
pub struct UseName(pub Use);

impl fmt::Display for UseName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.0 {
            Use::Pdo(_, number) => return write!(f, "{number}"),
            Use::Srdo(_, number, Half::Normal) => return write!(f, "SRDO {number} data"),
            Use::Srdo(_, number, Half::Inverted) => return write!(f, "SRDO {number} inverted data"),
            Use::Nmt => "NMT",
            Use::Sync => "SYNC",
            Use::Time => "TIME",
            Use::Emcy(_) => "EMCY",
            Use::SdoRequest(_) => "SDO request",
            Use::SdoResponse(_) => "SDO response",
            Use::ErrorControl(_) => "error control",
            Use::LssRequest => "LSS request",
            Use::LssResponse => "LSS response",
            Use::GlobalFailSafe => "global fail-safe command",
            Use::FlyingMaster => "flying master",
            Use::CaseMarker => "case marker",
            Use::Unknown => "no known use",
        })
    }
}
