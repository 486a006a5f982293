//! The SDO channels of a device: the default channel, and further channels (1201h to 127Fh), each with its own server.

use super::context::Context;
use super::nmt;
use super::objects::Objects;
use super::overload::Requests;
use super::routes::{Route, Routes};
use super::sdo_server::SdoServer;
use super::service::{Event, Service};
use crate::Fault;
use crate::models::Timing;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::{self, Request};
use canvass_analyzer::{CobId, Multiplexer, NodeId};
use canvass_traces::{CanId, Frame, Timestamp};

const ERROR_REGISTER: Multiplexer = Multiplexer::new(object::ERROR_REGISTER, 0);
const READ_ERROR_REGISTER: Request = Request::upload(ERROR_REGISTER);

/// All SDO channels.
#[derive(Clone, Debug)]
pub(super) struct SdoChannels {
    server: SdoServer,
    further: Vec<FurtherChannel>,
    requests: Requests,
    /// A request received in stopped. A faulty firmware answers it after leaving that state.
    kept: Option<Frame>,
}

impl SdoChannels {
    /// The channels of a dictionary. `seed` determines random response times.
    pub fn new(objects: &Objects, seed: u64) -> Self {
        let sheet = objects.model.sheet();
        let (timing, blocks) = (sheet.timing, sheet.network.sdo_block_transfer);
        Self {
            server: SdoServer::new(timing, blocks, seed),
            further: FurtherChannel::all(objects, timing, blocks, seed),
            requests: Requests::new(),
            kept: None,
        }
    }

    /// Handles power-off and on: the count of requests restarts.
    pub const fn power_on(&mut self) {
        self.requests = Requests::new();
    }

    /// Whether frames with that CAN-ID are responses of this device.
    pub(crate) fn responds_with(&self, can_id: u16, node: NodeId) -> bool {
        can_id == sdo::RESPONSE_BASE + u16::from(node.raw())
            || self.further.iter().any(|channel| channel.responds_with(can_id))
    }

    /// Time of the next event of a server: an answer is ready, or a transfer expires.
    pub fn next(&self) -> Timestamp {
        self.further.iter().fold(self.server.timeout(), |next, channel| next.min(channel.server.timeout()))
    }

    /// Handles a request on the default channel.
    fn on_request(&mut self, now: Timestamp, frame: &Frame, context: &mut Context) {
        if context.phase == nmt::Phase::Stopped && context.has(Fault::SdoRequestKeptOverStop) {
            self.kept = Some(*frame);
        }
        if context.objects.wedged || !context.serves(nmt::Service::Sdo) || !self.requests.count(context.firmware()) {
            return;
        }
        self.server.handle(now, frame, &mut context.objects);
        if context.objects.wedged {
            return self.server.reset();
        }
        if frame.len() == 8 && Request::read(frame.data()) == Ok(READ_ERROR_REGISTER) {
            context.objects.errors.register_was_read();
        }
    }

    /// Drops all transfers and waiting answers.
    fn reset(&mut self) {
        self.server.reset();
        self.further.iter_mut().for_each(|channel| channel.server.reset());
    }

    fn configure(&mut self, objects: &Objects) {
        self.further.iter_mut().for_each(|channel| channel.configure(objects));
    }
}

impl Service for SdoChannels {
    fn handle(&mut self, now: Timestamp, route: Route, frame: &Frame, context: &mut Context) {
        match route {
            Route::FurtherSdo(position) => {
                if context.serves(nmt::Service::Sdo)
                    && let Some(channel) = self.further.get_mut(usize::from(position))
                {
                    channel.server.handle(now, frame, &mut context.objects);
                }
            }
            _ => self.on_request(now, frame, context),
        }
        if !context.objects.written.is_empty() {
            context.events.push_back(Event::Act);
        }
    }

    fn on_event(&mut self, now: Timestamp, event: Event, context: &mut Context) {
        match event {
            Event::Entered { .. } if context.serves(nmt::Service::Sdo) => {
                if let Some(frame) = self.kept.take() {
                    self.on_request(now, &frame, context);
                }
            }
            Event::Initialise => {
                self.kept = None;
                let is_kept = self.server.is_downloading() && context.has(Fault::SdoOpenDownloadSurvivesReset);
                if !is_kept && !context.has(Fault::SdoTransferSurvivesReset) {
                    self.server.boot();
                }
                self.further.iter_mut().for_each(|channel| channel.server.reset());
            }
            Event::Entered { .. }
                if !context.serves(nmt::Service::Sdo) && !context.has(Fault::SdoTransferSurvivesStop) =>
            {
                self.reset();
            }
            Event::Loaded => self.configure(&context.objects),
            Event::Written(at, _)
                if matches!(at.index.0, object::SDO_SERVER_PARAMETER..object::SDO_CLIENT_PARAMETER) =>
            {
                self.configure(&context.objects);
                context.routes_changed = true;
            }
            _ => {}
        }
    }

    /// Ends the transfers whose clients are silent.
    fn poll(&mut self, now: Timestamp, context: &mut Context) {
        self.server.expire(now, &context.objects);
        self.further.iter_mut().for_each(|channel| channel.server.expire(now, &context.objects));
    }

    fn transmit(&mut self, now: Timestamp, context: &mut Context) {
        let Some(node) = context.node else { return };
        while let Some(frame) = self.server.poll(now, node) {
            context.send(frame);
        }
        for channel in &mut self.further {
            while let Some(frame) = channel.poll(now, node) {
                context.send(frame);
            }
        }
    }

    fn find_routes(&self, context: &Context, routes: &mut Routes) {
        for (position, channel) in (0..).zip(&self.further) {
            channel.can_id().into_iter().for_each(|can_id| routes.set(can_id, Route::FurtherSdo(position)));
        }
        if let Some(node) = context.node {
            routes.set(sdo::REQUEST_BASE + u16::from(node.raw()), Route::Sdo);
        }
    }
}

/// Whether a request only reads: initiate upload or upload segment. Reading the error register does not count, as it
/// may acknowledge an error.
pub(super) fn is_plain_upload(frame: &Frame) -> bool {
    let [command, low, high, ..] = frame.bytes();
    matches!(command >> 5, 2 | 3) && u16::from_le_bytes([low, high]) != ERROR_REGISTER.index.0
}

#[derive(Clone, Debug)]
struct FurtherChannel {
    index: u16,
    server: SdoServer,
    request: CobId,
    response: CobId,
}

impl FurtherChannel {
    /// The further channels in the object dictionary.
    fn all(objects: &Objects, timing: Timing, blocks: bool, seed: u64) -> Vec<Self> {
        let new = |index| Self {
            index,
            server: SdoServer::new(timing, blocks, seed ^ u64::from(index)),
            request: CobId(CobId::INVALID),
            response: CobId(CobId::INVALID),
        };
        (0x1201..object::SDO_CLIENT_PARAMETER)
            .filter(|&index| objects.parameters.number(index, 1).is_some())
            .map(new)
            .collect()
    }

    /// Applies the COB-IDs of the channel.
    fn configure(&mut self, objects: &Objects) {
        let number = |sub| objects.parameters.number(self.index, sub).map_or(CobId::INVALID, |raw| raw as u32);
        (self.request, self.response) = (CobId(number(1)), CobId(number(2)));
        if self.can_id().is_none() {
            self.server.reset();
        }
    }

    /// The CAN-ID of requests; `None` unless both COB-IDs are valid.
    pub fn can_id(&self) -> Option<u16> {
        (self.request.is_valid() && self.response.is_valid()).then_some(self.request.can_id() as u16)
    }

    /// Whether frames with that CAN-ID are responses of this channel.
    pub(crate) fn responds_with(&self, can_id: u16) -> bool {
        self.can_id().is_some() && self.response.can_id() == u32::from(can_id)
    }

    /// The next ready answer as a frame.
    pub fn poll(&mut self, now: Timestamp, node: NodeId) -> Option<Frame> {
        // The answer of a further channel differs from an answer of the default channel only in its CAN-ID.
        let answer = self.server.poll(now, node)?;
        Frame::new(CanId::standard_masked(self.response.can_id()), answer.data())
    }
}
