//! Simulated devices: the state machines of a CANopen encoder, without I/O and without a clock.
//!
//! One file for each service. This one only puts them together: which frame goes to which service, which service works
//! in which state, and what a written object changes.

mod dispatch;
mod emcy;
mod encoder;
mod guarding;
mod heartbeat;
mod heartbeat_consumer;
mod lifecycle;
mod lss_slave;
mod motion;
mod nmt;
mod objects;
mod parameters;
mod sdo_server;
mod store;
mod tpdo;

pub use motion::Motion;

use crate::models::Model;
use crate::{Fault, Faults};
use canvass_analyzer::wire::{Wire, emcy as emcy_wire, error_control};
use canvass_analyzer::{CobId, Multiplexer, NodeId};
use canvass_traces::{Duration, Frame, Timestamp};
use emcy::Condition;
use guarding::NodeGuarding;
use heartbeat::HeartbeatProducer;
use heartbeat_consumer::{Guarded, HeartbeatConsumer};
use lss_slave::LssSlave;
use nmt::{Phase, Service};
use objects::Objects;
use sdo_server::SdoServer;
use std::collections::VecDeque;
use store::{Groups, Store, StoreCommand};
use tpdo::Tpdo;

/// A simulated device.
#[derive(Clone, Debug)]
pub struct Device {
    node: Option<NodeId>,
    /// The node-ID while none is stored.
    delivered_node: Option<NodeId>,
    phase: Phase,
    faults: Faults,
    objects: Objects,
    store: Store,
    sdo: SdoServer,
    heartbeat: HeartbeatProducer,
    consumer: HeartbeatConsumer,
    guarding: NodeGuarding,
    tpdos: Vec<Tpdo>,
    lss: LssSlave,
    /// When it is seen next whether the shaft is too fast.
    shaft_due: Timestamp,
    /// What is ready to be sent.
    outbox: VecDeque<Frame>,
}

/// More frames than that don't wait: a device that can't get rid of its frames loses them.
const LONGEST_OUTBOX: usize = 256;

/// The node-ID that a device without one takes its defaults from.
const PLACEHOLDER: NodeId = NodeId::MAX;

impl Device {
    /// A device of that model, switched on at time 0, as delivered but for its node-ID; `None`: it has none, and has
    /// to be given one by LSS. `seed` chooses what is left to chance: how response times vary.
    pub fn new(model: &Model, node: Option<NodeId>, faults: Faults, seed: u64) -> Self {
        Self::with_motion(model, node, faults, seed, Motion::still(REST_POSITION))
    }

    /// As [`Device::new`], with a shaft that moves.
    pub fn with_motion(model: &Model, node: Option<NodeId>, faults: Faults, seed: u64, motion: Motion) -> Self {
        let sheet = model.sheet();
        let objects = Objects::new(model, node, motion, faults);
        let mut device = Self {
            node,
            delivered_node: node,
            phase: Phase::Unconfigured,
            faults,
            store: Store::new(model, &objects.parameters),
            sdo: SdoServer::new(sheet.timing, sheet.network.sdo_block_transfer, seed),
            heartbeat: HeartbeatProducer::new(),
            consumer: HeartbeatConsumer::new(),
            guarding: NodeGuarding::new(),
            tpdos: Tpdo::all(&objects.parameters),
            lss: LssSlave::new(),
            shaft_due: Timestamp::MAX,
            outbox: VecDeque::with_capacity(LONGEST_OUTBOX),
            objects,
        };
        device.initialise(Timestamp::ZERO, Groups::ALL);
        device
    }

    /// The node-ID in use.
    pub fn node(&self) -> Option<NodeId> {
        self.node
    }

    /// Lets the shaft move so from now on; the position at time 0 is part of the motion.
    pub fn set_motion(&mut self, now: Timestamp, motion: Motion) {
        if let Some(encoder) = &mut self.objects.encoder {
            encoder.set_motion(motion);
        }
        self.watch_shaft(now);
        self.configure_tpdos(now);
        self.after_change(now);
        self.hand_out(now);
    }

    fn on_sdo(&mut self, now: Timestamp, frame: &Frame) {
        if !self.phase.serves(Service::Sdo, self.faults) || self.objects.wedged {
            return;
        }
        self.sdo.handle(now, frame, &mut self.objects);
        if self.objects.wedged {
            return self.sdo.reset();
        }
        while let Some((at, value)) = self.objects.written.pop() {
            self.act_on(now, at, value);
        }
    }

    /// What a written object changes.
    fn act_on(&mut self, now: Timestamp, at: Multiplexer, value: u64) {
        let storage = &self.objects.model.sheet().storage;
        if let Some(command) = StoreCommand::of(at, storage) {
            let ignored = matches!(command, StoreCommand::Save(_)) && self.faults.has(Fault::StoreWithoutEffect);
            if matches!(command, StoreCommand::Restore(_)) && self.faults.has(Fault::RestoreAtOnce) {
                self.objects.parameters.restore(self.node.unwrap_or(PLACEHOLDER));
            }
            if !ignored {
                self.store.begin(now + self.objects.model.sheet().timing.store(), command);
            }
        }
        match at.index.0 {
            0x1003 => self.objects.errors.clear_history(),
            0x100C | 0x100D => self.configure_guarding(now),
            0x1016 if self.heartbeat_consumer_acts(at) => self.consumer.configure(&self.objects.parameters),
            0x1017 => self.heartbeat.start(now, value, self.faults),
            0x1800..0x1C00 | 0x6200 => self.configure_tpdos(now),
            _ => {}
        }
        self.after_change(now);
    }

    fn heartbeat_consumer_acts(&self, at: Multiplexer) -> bool {
        let needs_store = self.objects.model.sheet().network.heartbeat_consumer_needs_store;
        !needs_store || self.store.number(at, &self.objects.parameters).is_some()
    }

    /// Values have changed: errors may have come or gone, PDOs may have to be sent.
    fn after_change(&mut self, now: Timestamp) {
        self.find_errors(now);
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.on_change(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    pub(super) fn find_errors(&mut self, now: Timestamp) {
        let Objects { parameters, errors, encoder, .. } = &mut self.objects;
        if let (Some(low), Some(high)) = (parameters.number(0x2120, 2), parameters.number(0x2120, 3)) {
            let (low, high) = (low as u8, high as u8);
            let outside = !(low..=high).contains(&TEMPERATURE) && !self.faults.has(Fault::WarningWithoutEmcy);
            errors.set(Condition::Temperature { now: TEMPERATURE, low, high }, outside);
        }
        if let Some(encoder) = encoder {
            errors.set(Condition::Overspeed, encoder.is_overspeed(now, parameters));
            errors.set(Condition::Position, encoder.has_position_error());
        }
    }

    /// A shaft that turns can become too fast, or be so no longer, without anything being written.
    fn watch_shaft(&mut self, now: Timestamp) {
        let warns = self.objects.model.sheet().encoder.is_some_and(|encoder| encoder.speed_warning_rpm.is_some());
        let watched = warns && self.objects.is_moving() && self.phase.is_running();
        self.shaft_due = if watched { now + SHAFT_WATCH } else { Timestamp::MAX };
    }

    fn start_heartbeat(&mut self, now: Timestamp) {
        let time = self.objects.parameters.number_or_zero(0x1017, 0);
        self.heartbeat.start(now, time, self.faults);
    }

    fn configure_guarding(&mut self, now: Timestamp) {
        let number = |index| self.objects.parameters.number_or_zero(index, 0);
        self.guarding.configure(now, number(0x100C), number(0x100D));
    }

    fn configure_tpdos(&mut self, now: Timestamp) {
        self.tpdos.iter_mut().for_each(|tpdo| tpdo.configure(now, &self.objects));
    }

    fn start_tpdos(&mut self, now: Timestamp) {
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.start(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    /// The master or a watched node is missing, or back.
    fn on_guarded(&mut self, now: Timestamp, change: Guarded) {
        let lost = change == Guarded::Lost;
        self.objects.errors.set(Condition::Guarding, lost);
        if lost && self.phase.is_running() {
            // 1029h:01; without it, or with 0, operational is left.
            match self.objects.parameters.number_or_zero(0x1029, 1) {
                0 if self.phase == Phase::Operational => self.enter(now, Phase::PreOperational),
                2 => self.enter(now, Phase::Stopped),
                _ => {}
            }
        }
    }

    fn send_error_control(&mut self, message: error_control::ErrorControl) {
        if let Some(node) = self.node {
            push(&mut self.outbox, message.to_frame(error_control::CAN_ID_BASE + u16::from(node.raw())));
        }
    }

    /// The next EMCY, if there is one and it may be sent.
    fn poll_emcy(&mut self, now: Timestamp) -> Option<Frame> {
        if now < self.emcy_timeout() {
            return None;
        }
        let cob_id = self.objects.parameters.number(0x1014, 0).map(|raw| CobId(raw as u32));
        let inhibit = Duration::from_micros(100 * self.objects.parameters.number_or_zero(0x1015, 0));
        let emcy = self.objects.errors.poll(now, inhibit)?;
        let node = u32::from(self.node?.raw());
        let cob_id = cob_id.unwrap_or(CobId(u32::from(emcy_wire::CAN_ID_BASE) + node));
        cob_id.is_valid().then(|| emcy.to_frame(cob_id.can_id() as u16))
    }

    fn emcy_timeout(&self) -> Timestamp {
        match self.phase.serves(Service::Emcy, self.faults) {
            true => self.objects.errors.timeout(),
            false => Timestamp::MAX,
        }
    }
}

/// The position of a shaft that nobody turns, in physical steps.
const REST_POSITION: i64 = 0x4CBA;

/// How often the speed of a shaft that turns is compared with its limit.
const SHAFT_WATCH: Duration = Duration::from_millis(100);

/// The temperature of the sensor as 2120h counts it: degrees Celsius plus 64.
const TEMPERATURE: u8 = 0x56;

fn push(outbox: &mut VecDeque<Frame>, frame: Frame) {
    if outbox.len() < LONGEST_OUTBOX {
        outbox.push_back(frame);
    }
}
