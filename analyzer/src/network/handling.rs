//! Handling of frames: their meaning in the current state, and the changes of state.

use super::bus::Bus;
use super::cob_ids::{Source, Use};
use super::event::{Emergency, Event, StateChange};
use super::node::Cause;
use super::sdo::{Channel, ChannelIndex, Step, Violation};
use super::{Decoded, configured, learning};
use crate::NodeId;
use crate::dictionary::KnownDevice;
use crate::message::{Message, PdoNumber, Service};
use crate::wire::case_marker::CaseMarker;
use crate::wire::error_control::{ErrorControl, State};
use crate::wire::flying_master::FlyingMaster;
use crate::wire::layer_setting::Protocol;
use crate::wire::mpdo::Mpdo;
use crate::wire::nmt::{Command, Nmt};
use crate::wire::sdo::{Request, Response};
use crate::wire::srdo::Half;
use crate::wire::sync::Sync;
use crate::wire::time::TimeOfDay;
use crate::wire::{Malformed, Wire, emcy::Emcy, lmt, lss};
use canvass_traces::{Duration, Frame, FrameKind, Record, Timestamp};
use std::sync::Arc;

impl Bus {
    /// Sets the device of a node.
    pub fn describe(&mut self, id: NodeId, device: &Arc<KnownDevice>) {
        if std::mem::take(&mut self.handled) {
            self.events.clear();
        }
        learning::after_description(self, id, device);
    }

    /// Handles the next record; returns its meaning.
    pub fn handle(&mut self, record: &Record) -> Decoded {
        if std::mem::replace(&mut self.handled, true) {
            self.events.clear();
        }
        let frame = &record.frame;
        match (frame.cob_id(), frame.kind()) {
            (Some(can_id), _) => self.data(record.timestamp, can_id, frame),
            (None, FrameKind::Error) => {
                let class = frame.error_class().unwrap_or(canvass_traces::ErrorClass(0));
                plain(Service::ErrorFrame, None, Message::ErrorFrame(class))
            }
            (None, FrameKind::Remote) => self.remote(record.timestamp, frame),
            (None, FrameKind::Data) => plain(Service::Unknown, None, Message::Foreign),
        }
    }

    fn data(&mut self, now: Timestamp, can_id: u16, frame: &Frame) -> Decoded {
        let (used, source) = self.cob_ids.get(can_id);
        let payload = frame.data();
        let mut decoded = match used {
            Use::Nmt => self.nmt(payload),
            Use::Sync => read::<Sync>(Service::Sync, None, payload, Message::Sync),
            Use::Time => read::<TimeOfDay>(Service::Time, None, payload, Message::Time),
            Use::Emcy(node) => self.emcy(now, node, payload),
            Use::Pdo(node, number) => self.pdo(node, number, payload),
            Use::SdoRequest(channel) => self.sdo(channel, |channel| channel.request(now, payload)),
            Use::SdoResponse(channel) => self.sdo(channel, |channel| channel.response(now, payload)),
            Use::ErrorControl(node) => self.error_control(now, node, payload),
            Use::LssRequest => self.layer_setting_request(now, payload),
            Use::LssResponse => self.layer_setting_response(now, payload),
            Use::Srdo(node, number, half) => self.srdo(now, (node, number, half), frame),
            Use::GlobalFailSafe => plain(Service::Srdo, None, Message::GlobalFailSafe),
            Use::FlyingMaster => flying_master(can_id, payload),
            Use::CaseMarker => case_marker(payload),
            Use::Unknown => self.unknown(now, can_id, frame),
        };
        decoded.source = source;
        // PDOs are not judged, as any bytes may be a PDO.
        if source != Source::Predefined && decoded.service != Service::Pdo {
            let fits = fits(&decoded);
            if !fits || self.cob_ids.is_doubted(can_id) {
                self.cob_ids.judge(can_id, fits);
            }
        }
        decoded
    }

    /// A frame without a known use: it is part of an SRDO if its inverted frame follows.
    fn unknown(&mut self, now: Timestamp, can_id: u16, frame: &Frame) -> Decoded {
        match self.srdo_pairs.handle(now, can_id, frame) {
            Some((pair, srdo)) => plain(Service::Srdo, pair.node(), Message::Srdo(srdo)),
            None => plain(Service::Unknown, None, Message::Unknown),
        }
    }

    /// A frame of an SRDO with known parameters.
    #[cold]
    fn srdo(&mut self, now: Timestamp, (id, number, half): (NodeId, u8, Half), frame: &Frame) -> Decoded {
        // Computes the layout if it is not known yet, as for PDOs.
        self.node_mut(id).srdo_layout(id, number);
        let srdo = self.srdo_pairs.configured(now, id, number, half, frame);
        plain(Service::Srdo, Some(id), Message::Srdo(srdo))
    }

    #[cold]
    fn layer_setting_request(&mut self, now: Timestamp, payload: &[u8]) -> Decoded {
        let decoded = match self.protocol(payload) {
            Protocol::Lss => read::<lss::Request>(Service::Lss, None, payload, Message::LssRequest),
            Protocol::Lmt => read::<lmt::Request>(Service::Lmt, None, payload, Message::LmtRequest),
        };
        match decoded.message {
            Message::LssRequest(request) => self.layer_setting.lss_request(now, request, &mut self.events),
            Message::LmtRequest(request) => self.layer_setting.lmt_request(now, request, &mut self.events),
            _ => {}
        }
        decoded
    }

    #[cold]
    fn layer_setting_response(&mut self, now: Timestamp, payload: &[u8]) -> Decoded {
        let decoded = match self.protocol(payload) {
            Protocol::Lss => read::<lss::Response>(Service::Lss, None, payload, Message::LssResponse),
            Protocol::Lmt => read::<lmt::Response>(Service::Lmt, None, payload, Message::LmtResponse),
        };
        match decoded.message {
            Message::LssResponse(response) => self.layer_setting.response(now, response, &mut self.events),
            Message::LmtResponse(response) => self.layer_setting.response(now, response, &mut self.events),
            _ => {}
        }
        decoded
    }

    /// The protocol of a message on 7E5h or 7E4h. If both protocols have the message, earlier messages tell the
    /// protocol, or else the descriptions of the devices.
    fn protocol(&mut self, payload: &[u8]) -> Protocol {
        self.protocol = Protocol::of(payload).or(self.protocol);
        self.protocol.unwrap_or_else(|| self.described_protocol())
    }

    /// LMT if a device on the bus supports LMT and no device supports LSS.
    fn described_protocol(&self) -> Protocol {
        let nodes = self.nodes.iter().filter_map(|(_, node)| node.as_deref());
        let mut devices = nodes.filter_map(|node| node.device.as_deref());
        let mut known = false;
        let only_lmt = devices.all(|device| {
            known |= device.manual.settings.layer_management;
            !device.description.device.lss_supported
        });
        if known && only_lmt { Protocol::Lmt } else { Protocol::Lss }
    }

    #[cold]
    fn remote(&mut self, now: Timestamp, frame: &Frame) -> Decoded {
        let used = frame.id().as_standard().filter(|_| !frame.is_fd()).map(|id| self.cob_ids.get(id));
        match used {
            Some((Use::ErrorControl(node), source)) => {
                self.node_mut(node).guarding.ask(now);
                Decoded { source, ..plain(Service::Guarding, Some(node), Message::GuardingRequest) }
            }
            Some((Use::Pdo(node, number @ PdoNumber::Transmit(_)), source)) => {
                Decoded { source, ..plain(Service::Pdo, Some(node), Message::PdoRequest(number)) }
            }
            _ => plain(Service::Unknown, None, Message::UnexpectedRemote),
        }
    }

    /// Kept out of line, as NMT commands are rare. The same holds for other functions marked cold here.
    #[cold]
    fn nmt(&mut self, payload: &[u8]) -> Decoded {
        let command = match Nmt::read(payload) {
            Ok(command) => command,
            Err(error) => return malformed(Service::Nmt, None, error),
        };
        let event = match NodeId::new(command.node) {
            Some(node) => self.commanded(node, command.command),
            None if command.node == 0 => {
                for node in NodeId::all() {
                    if self.node(node).is_some() {
                        self.commanded(node, command.command);
                    }
                }
                None
            }
            None => None,
        };
        Decoded { event, ..plain(Service::Nmt, NodeId::new(command.node), Message::Nmt(command)) }
    }

    /// Handles an NMT command as if the node had obeyed it; error control corrects the state if the node did not obey.
    fn commanded(&mut self, id: NodeId, command: Command) -> Option<Event> {
        self.turn += 1;
        let node = self.node_mut(id);
        let from = node.state.map(|state| state.0);
        let to = node.obey(command)?;
        let event = Event::StateChanged(id, StateChange { from, to, cause: Cause::Command });
        if from != Some(to) {
            self.events.push(event);
        }
        Some(event)
    }

    fn error_control(&mut self, now: Timestamp, id: NodeId, payload: &[u8]) -> Decoded {
        let message = match ErrorControl::read(payload) {
            Ok(message) => message,
            Err(error) => return malformed(Service::Heartbeat, Some(id), error),
        };
        let (service, to, cause) = if message.is_boot_up() {
            (Service::BootUp, State::PRE_OPERATIONAL, Cause::BootUp)
        } else if self.node_mut(id).guarding.is_answer(now, message.toggle) {
            (Service::Guarding, message.state, Cause::ErrorControl)
        } else {
            (Service::Heartbeat, message.state, Cause::ErrorControl)
        };
        let is_known = message.is_boot_up() && self.has_just_started(now, id, false);
        let event = if is_known { None } else { self.state_seen(id, to, cause) };
        Decoded { event, ..plain(service, Some(id), Message::ErrorControl(message)) }
    }

    /// Handles a state that the node itself showed.
    fn state_seen(&mut self, id: NodeId, to: State, cause: Cause) -> Option<Event> {
        let node = self.node_mut(id);
        let from = node.state.map(|from| from.0);
        node.state = Some((to, cause));
        let changed = cause == Cause::BootUp || from != Some(to);
        let event = changed.then_some(Event::StateChanged(id, StateChange { from, to, cause }));
        self.events.extend(event);
        if cause == Cause::BootUp {
            self.started(id);
        }
        event
    }

    /// Handles the start of a node: it has its stored parameters, and perhaps another node-ID.
    #[cold]
    fn started(&mut self, id: NodeId) {
        learning::after_boot_up(self, id);
        let given = configured::started(self, id);
        match (self.layer_setting.started(id), given) {
            (Some(before), _) => learning::after_new_node_id(self, id, &before),
            (None, Some((from, object))) => learning::after_written_node_id(self, from, id, object),
            (None, None) => {}
        }
    }

    fn emcy(&mut self, now: Timestamp, id: NodeId, payload: &[u8]) -> Decoded {
        let decoded = emcy(id, Source::Predefined, payload);
        if !payload.is_empty() {
            self.emergency(now, id, &decoded.message);
            return decoded;
        }
        // Before CiA 301 V4 an empty EMCY was the boot-up message.
        let is_known = self.has_just_started(now, id, true);
        let event = if is_known { None } else { self.state_seen(id, State::PRE_OPERATIONAL, Cause::BootUp) };
        Decoded { service: Service::BootUp, event, ..decoded }
    }

    /// Whether a boot-up message repeats the other kind of boot-up message just before: devices from the time between
    /// the versions of CiA 301 send both.
    fn has_just_started(&mut self, now: Timestamp, id: NodeId, by_emcy: bool) -> bool {
        const SOON: Duration = Duration::from_millis(1_000);
        let started = &mut self.node_mut(id).started;
        let is_known = started.is_some_and(|(at, other)| other != by_emcy && now.since(at) <= SOON);
        *started = if is_known { None } else { Some((now, by_emcy)) };
        is_known
    }

    fn emergency(&mut self, now: Timestamp, id: NodeId, message: &Message) {
        let Message::Emcy(emcy) = *message else { return };
        let since = &mut self.node_mut(id).error_since;
        let is_reset = emcy.code().is_some_and(|code| code.is_reset());
        let since = if is_reset { since.take() } else { Some(*since.get_or_insert(now)) };
        self.events.push(Event::Emergency(id, Emergency { emcy, since }));
    }

    fn pdo(&mut self, id: NodeId, number: PdoNumber, payload: &[u8]) -> Decoded {
        if let PdoNumber::Transmit(tpdo) = number
            && self.node_mut(id).device.is_none()
        {
            learning::received(self, id, tpdo, payload.len());
        }
        // Computes the layout if it is not known yet: the texts of the PDO find it in the node.
        let node = self.node_mut(id);
        node.layout(id, number);
        if node.addressing(number).is_none() {
            return plain(Service::Pdo, Some(id), Message::Pdo(number));
        }
        match Mpdo::read(payload) {
            Ok(mpdo) => {
                let message = Message::Mpdo(number, mpdo);
                Decoded { object: Some(mpdo.object), ..plain(Service::Pdo, Some(id), message) }
            }
            Err(error) => malformed(Service::Pdo, Some(id), error),
        }
    }

    fn sdo(&mut self, index: ChannelIndex, step: impl FnOnce(&mut Channel) -> Step) -> Decoded {
        let Some(channel) = self.channels.get_mut(usize::from(index.0)) else {
            return plain(Service::Unknown, None, Message::Unknown);
        };
        let step = step(channel);
        channel.settle(&self.values);
        let server = channel.server;
        let object = channel.transfer().map(|transfer| transfer.multiplexer);
        if step.superseded {
            self.events.push(Event::TransferLeft(index));
        }
        if step.ended {
            self.events.push(Event::TransferEnded);
            // An answer about another object says nothing about the requested one.
            if !matches!(step.violation, Some(Violation::Multiplexer(_))) {
                learning::from_transfer(self, index);
            }
        }
        Decoded {
            object: own_object(&step.message).or(object),
            channel: Some(index),
            event: step.ended.then_some(Event::TransferEnded),
            violation: step.violation,
            ..plain(Service::Sdo, Some(server), step.message)
        }
    }
}

/// Whether a frame fits the use of its CAN-ID.
const fn fits(decoded: &Decoded) -> bool {
    match decoded.message {
        Message::Malformed(..) => false,
        Message::SdoRequest(Request::Unknown { .. }) | Message::SdoResponse(Response::Unknown { .. }) => false,
        _ => !matches!(decoded.violation, Some(Violation::Unexpected)),
    }
}

/// The object that an SDO message itself names.
fn own_object(message: &Message) -> Option<crate::Multiplexer> {
    match message {
        Message::SdoRequest(request) => request.multiplexer(),
        Message::SdoResponse(response) => response.multiplexer(),
        _ => None,
    }
}

fn plain(service: Service, node: Option<NodeId>, message: Message) -> Decoded {
    Decoded {
        service,
        node,
        message,
        source: Source::Predefined,
        object: None,
        channel: None,
        event: None,
        violation: None,
    }
}

fn flying_master(can_id: u16, payload: &[u8]) -> Decoded {
    match FlyingMaster::read(can_id, payload) {
        Ok(message) => {
            let node = match message {
                FlyingMaster::ActiveMaster { node, .. } => NodeId::new(node),
                _ => None,
            };
            plain(Service::FlyingMaster, node, Message::FlyingMaster(message))
        }
        Err(error) => malformed(Service::FlyingMaster, None, error),
    }
}

fn case_marker(payload: &[u8]) -> Decoded {
    plain(Service::Unknown, None, CaseMarker::read(payload).map_or(Message::Unknown, Message::CaseMarker))
}

/// An EMCY message of a node.
pub(super) fn emcy(node: NodeId, source: Source, payload: &[u8]) -> Decoded {
    Decoded { source, ..read::<Emcy>(Service::Emcy, Some(node), payload, Message::Emcy) }
}

fn malformed(service: Service, node: Option<NodeId>, error: Malformed) -> Decoded {
    plain(service, node, Message::Malformed(service, error))
}

fn read<M: Wire>(
    service: Service,
    node: Option<NodeId>,
    payload: &[u8],
    message: impl FnOnce(M) -> Message,
) -> Decoded {
    match M::read(payload) {
        Ok(read) => plain(service, node, message(read)),
        Err(error) => malformed(service, node, error),
    }
}
