//! Other clients of the device under test: the bench recognises them, does not take their answers for answers to the
//! tester, and sends its own requests in quiet moments.

mod addresses;
mod echo;
mod queue;

use super::foreign::{Foreign, Form};
use crate::foreign::{ForeignKind, ForeignMessages};
use addresses::Addresses;
use canvass_analyzer::dictionary::DeviceDescription;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::error_control;
use canvass_analyzer::wire::sdo::{self, Request, Response};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::{Direction, Duration, Record, Timestamp};
use echo::Echo;
use queue::ServerQueue;
use std::collections::BTreeMap;

/// The tester's knowledge of other clients.
#[derive(Debug)]
pub(crate) struct Clients {
    node: NodeId,
    /// The addresses that the device listens to in its own configuration.
    usual: Addresses,
    /// The addresses that the device listens to with the configuration that the case has written.
    now: Addresses,
    echo: Echo,
    queue: ServerQueue,
    /// The write of the tester that the device has not confirmed yet.
    written: Option<(Multiplexer, u32)>,
    /// The frames that others have sent in the case.
    foreign: Foreign,
    /// Numbers of messages that others sent before the case.
    before: BTreeMap<(ForeignKind, u16), u64>,
    /// Number of transfers that ended badly while others used the server.
    collisions: u64,
    /// Whether the last frame was an answer to others.
    answered_others: bool,
}

impl Clients {
    pub fn new(node: NodeId, description: Option<&DeviceDescription>) -> Self {
        let usual = description.map_or_else(|| Addresses::predefined(node), |known| described(node, known));
        let now = usual.clone();
        Self {
            node,
            usual,
            now,
            echo: Echo::default(),
            queue: ServerQueue::default(),
            written: None,
            foreign: Foreign::default(),
            before: BTreeMap::new(),
            collisions: 0,
            answered_others: false,
        }
    }

    /// Takes a frame from the bus. Returns whether others sent it, rather than the device or the tester.
    pub fn observe(&mut self, record: &Record) -> bool {
        let (at, is_own) = (record.timestamp, record.direction == Direction::Tx);
        self.answered_others = false;
        if is_own {
            self.echo.sent(&record.frame, at);
        } else if self.echo.gives_back(&record.frame, at) {
            return false;
        }
        let node = u16::from(self.node.raw());
        match record.frame.cob_id() {
            Some(id) if id == sdo::REQUEST_BASE + node => {
                if let Ok(request) = Request::read(record.data()) {
                    self.on_request(request, is_own, at);
                }
            }
            Some(id) if id == error_control::CAN_ID_BASE + node && record.data() == [0] => self.queue.reset(),
            Some(id) if id == sdo::RESPONSE_BASE + node && !is_own => {
                self.on_response(Response::read(record.data()).ok().as_ref(), at);
            }
            _ => {}
        }
        !is_own
    }

    /// The meaning of a frame for the device. A frame without a meaning in the configuration of the case has the
    /// meaning that it has in the device's own configuration, if others sent such frames before the case.
    fn kind(&self, can_id: u16, form: Form) -> Option<ForeignKind> {
        let usual = || self.usual.kind(can_id, form).filter(|kind| self.before.contains_key(&(*kind, can_id)));
        self.now.kind(can_id, form).or_else(usual)
    }

    fn on_request(&mut self, request: Request, is_own: bool, at: Timestamp) {
        self.queue.ask(request, !is_own, at);
        if let Request::InitiateDownload { multiplexer, payload } = request
            && is_own
        {
            self.written = payload.value().map(|value| (multiplexer, super::sdo::number(value)));
        }
    }

    fn on_response(&mut self, response: Option<&Response>, at: Timestamp) {
        self.answered_others = self.queue.answer(response, at);
        let Some(Response::InitiateDownload { multiplexer }) = response else { return };
        if let Some((_, value)) = self.written.take_if(|(written, _)| written == multiplexer) {
            self.now.learn(*multiplexer, value);
        }
    }

    /// Counts a frame of others.
    pub fn count(&mut self, record: &Record) {
        self.foreign.count(record, self.node);
    }

    /// The traffic of nodes other than the tester and the device in the case, with its bus load.
    pub const fn foreign(&self) -> &Foreign {
        &self.foreign
    }

    /// Takes the values of the device's dictionary, which define its CAN-IDs.
    pub(crate) fn learn_addresses(&mut self, values: &[(Multiplexer, Vec<u8>)]) {
        let numbers = values.iter().filter(|(_, value)| value.len() <= 4);
        let numbers = numbers.map(|(at, value)| (*at, super::sdo::number(value)));
        self.usual = Addresses::of_values(self.node, numbers);
        self.now = self.usual.clone();
    }

    /// The foreign messages of the case.
    pub fn messages(&self) -> Vec<ForeignMessages> {
        self.foreign.messages(|can_id, form| self.kind(can_id, form))
    }

    /// The foreign messages since the start of the run.
    pub(crate) fn messages_of_run(&self) -> Vec<ForeignMessages> {
        let mut counts = self.before.clone();
        count(&mut counts, self.messages());
        counts.into_iter().map(|((kind, can_id), count)| ForeignMessages { kind, can_id, count }).collect()
    }

    /// Begins a case: the addresses that the last case configured are dropped, the counts of foreign messages stay.
    pub fn begin(&mut self) {
        let messages = self.messages();
        count(&mut self.before, messages);
        self.foreign = Foreign::default();
        self.now = self.usual.clone();
    }

    /// Whether the last frame was an answer of the SDO server to others.
    pub(crate) const fn has_answered_others(&self) -> bool {
        self.answered_others
    }

    /// The time until which the SDO server answers requests of others, if each answer takes at most `patience`.
    pub(crate) fn busy_until(&self, now: Timestamp, patience: Duration) -> Option<Timestamp> {
        self.queue.busy_until(now, patience)
    }

    /// The period of the others' requests, and the time at which the next one is due.
    pub(crate) fn next_request(&self) -> Option<(Duration, Timestamp)> {
        self.queue.next_foreign()
    }

    /// Number of requests that others have sent to the SDO server.
    pub const fn requests(&self) -> u64 {
        self.queue.foreign()
    }

    /// Counts a transfer that ended badly while others used the server.
    pub(crate) fn add_collision(&mut self) {
        self.collisions += 1;
    }

    /// Number of transfers that ended badly while others used the server.
    pub(crate) const fn collisions(&self) -> u64 {
        self.collisions
    }
}

fn count(counts: &mut BTreeMap<(ForeignKind, u16), u64>, messages: Vec<ForeignMessages>) {
    for ForeignMessages { kind, can_id, count } in messages {
        *counts.entry((kind, can_id)).or_default() += count;
    }
}

/// The addresses of a device that matches its description.
fn described(node: NodeId, description: &DeviceDescription) -> Addresses {
    let values = description.dictionary.entries().filter_map(|(at, entry)| {
        let value = entry.default.as_ref()?.resolve(entry.data_type, node).as_number()?;
        Some((at, u32::try_from(value).ok()?))
    });
    Addresses::of_values(node, values)
}
