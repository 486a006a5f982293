//! Other clients of the device under test: they are recognised, its answers to them are not taken for those to the tester, and
//! requests wait for quiet moments.

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

/// What is known of other clients.
#[derive(Debug)]
pub(crate) struct Clients {
    node: NodeId,
    /// The addresses that the device listens to in its own configuration.
    usual: Addresses,
    /// The addresses that the device listens to with the configuration that the case has written.
    now: Addresses,
    echo: Echo,
    queue: ServerQueue,
    /// What the tester writes, until the device has taken it.
    written: Option<(Multiplexer, u32)>,
    /// What others have sent in the case.
    foreign: Foreign,
    /// What they sent before it.
    before: BTreeMap<(ForeignKind, u16), u64>,
    /// Transfers that ended badly while others asked the server.
    collisions: u64,
    /// The last frame was an answer to others.
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

    /// Takes a frame that was on the bus. Whether it came from others, or from the device.
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

    /// What frames of that form and CAN-ID are to the device. What it sends itself in this case, as others did before, both send.
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

    /// How much of the bus others than the tester and the device have taken in the case.
    pub const fn foreign(&self) -> &Foreign {
        &self.foreign
    }

    /// Says what the device holds: what concerns it on the bus.
    pub fn learn_addresses(&mut self, values: &[(Multiplexer, Vec<u8>)]) {
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
    pub fn messages_of_run(&self) -> Vec<ForeignMessages> {
        let mut counts = self.before.clone();
        count(&mut counts, self.messages());
        counts.into_iter().map(|((kind, can_id), count)| ForeignMessages { kind, can_id, count }).collect()
    }

    /// A case begins: what the case before has told the device counts no more, what others have sent does.
    pub fn begin(&mut self) {
        let messages = self.messages();
        count(&mut self.before, messages);
        self.foreign = Foreign::default();
        self.now = self.usual.clone();
    }

    /// Whether the last frame was an answer of the SDO server to others.
    pub const fn has_answered_others(&self) -> bool {
        self.answered_others
    }

    /// Until when the SDO server has requests of others to answer, if each takes no longer than `patience`.
    pub fn busy_until(&self, now: Timestamp, patience: Duration) -> Option<Timestamp> {
        self.queue.busy_until(now, patience)
    }

    /// The period of the others' requests, and when the next one is due.
    pub fn next_request(&self) -> Option<(Duration, Timestamp)> {
        self.queue.next_foreign()
    }

    /// How many requests others have sent to the SDO server.
    pub const fn requests(&self) -> u64 {
        self.queue.foreign()
    }

    /// A transfer ended badly while others asked the server.
    pub fn add_collision(&mut self) {
        self.collisions += 1;
    }

    /// How many transfers ended badly while others asked the server.
    pub const fn collisions(&self) -> u64 {
        self.collisions
    }
}

fn count(counts: &mut BTreeMap<(ForeignKind, u16), u64>, messages: Vec<ForeignMessages>) {
    for ForeignMessages { kind, can_id, count } in messages {
        *counts.entry((kind, can_id)).or_default() += count;
    }
}

/// What a device that is as described listens to.
fn described(node: NodeId, description: &DeviceDescription) -> Addresses {
    let values = description.dictionary.entries().filter_map(|(at, entry)| {
        let value = entry.default.as_ref()?.resolve(entry.data_type, node).as_number()?;
        Some((at, u32::try_from(value).ok()?))
    });
    Addresses::of_values(node, values)
}
