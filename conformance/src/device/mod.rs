//! Simulated devices: the state machines of a CANopen encoder, without I/O and without a clock.
//!
//! One file for each service. This one only puts them together: which frame goes to which service, which service works
//! in which state, and what a written object changes.

mod emcy;
mod encoder;
mod guarding;
mod heartbeat;
mod heartbeat_consumer;
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
use crate::{Fault, Faults, Machine};
use canvass_analyzer::wire::{Wire, emcy as emcy_wire, error_control, lss, nmt as nmt_wire, sdo};
use canvass_analyzer::{CobId, Multiplexer, NodeId};
use canvass_traces::{Duration, Frame, Timestamp};
use emcy::Condition;
use encoder::Encoder;
use guarding::NodeGuarding;
use heartbeat::HeartbeatProducer;
use heartbeat_consumer::{Guarded, HeartbeatConsumer};
use lss_slave::LssSlave;
use nmt::{Order, Phase, Service};
use objects::Objects;
use sdo_server::SdoServer;
use std::collections::VecDeque;
use store::{Groups, Store, StoreCommand};
use tpdo::Tpdo;

/// A simulated device.
#[derive(Clone, Debug)]
pub struct Device {
    node: Option<NodeId>,
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
        let objects = Objects::new(model, node.unwrap_or(PLACEHOLDER), motion, faults);
        let mut device = Self {
            node,
            phase: Phase::Unconfigured,
            faults,
            store: Store::new(model, &objects.parameters),
            sdo: SdoServer::new(sheet.timing, sheet.network.sdo_block_transfer, seed),
            heartbeat: HeartbeatProducer::new(),
            consumer: HeartbeatConsumer::new(),
            guarding: NodeGuarding::new(),
            tpdos: Tpdo::all(&objects.parameters),
            lss: LssSlave::new(),
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
        self.configure_tpdos(now);
        self.after_change(now);
        self.hand_out(now);
    }

    /// Off and on again: what was not stored is lost.
    pub fn power_cycle(&mut self, now: Timestamp) {
        self.objects.errors.clear_history();
        self.lss = LssSlave::new();
        self.reset(now, Order::ResetNode);
    }

    /// Begins to initialise, with the stored values of those groups.
    fn initialise(&mut self, now: Timestamp, groups: Groups) {
        self.outbox.clear();
        self.heartbeat.stop();
        self.guarding = NodeGuarding::new();
        self.sdo.boot();
        self.objects.errors.reset();
        self.objects.written.clear();
        self.tpdos.iter_mut().for_each(Tpdo::stop);
        let node = self.node.unwrap_or(PLACEHOLDER);
        self.store.load(groups, &mut self.objects.parameters, self.objects.encoder.as_mut(), node);
        self.phase = match self.node {
            Some(_) => Phase::Initialising { until: now + self.objects.model.sheet().timing.boot() },
            None => Phase::Unconfigured,
        };
    }

    /// The end of initialisation.
    fn boot_up(&mut self, now: Timestamp) {
        self.phase = Phase::PreOperational;
        if self.objects.model.sheet().network.boot_up_message {
            for message in heartbeat::boot_up(self.faults) {
                self.send_error_control(message);
            }
        }
        self.start_heartbeat(now);
        self.consumer.configure(&self.objects.parameters);
        self.configure_guarding(now);
        self.configure_tpdos(now);
        self.after_change(now);
        if self.faults.has(Fault::TpdoInPreOperational) {
            self.start_tpdos(now);
        }
        if Encoder::starts_in_operational(&self.objects.parameters) {
            self.enter(now, Phase::Operational);
        }
    }

    fn enter(&mut self, now: Timestamp, phase: Phase) {
        if self.phase == phase {
            return;
        }
        self.phase = phase;
        if phase.serves(Service::Pdo, self.faults) {
            self.start_tpdos(now);
        } else {
            self.tpdos.iter_mut().for_each(Tpdo::stop);
        }
        if !phase.serves(Service::Sdo, self.faults) {
            self.sdo.reset();
        }
        let (faults, node, tpdos) = (self.faults, self.node, &self.tpdos);
        self.outbox.retain(|frame| service_of(frame, node, tpdos).is_none_or(|service| phase.serves(service, faults)));
        if faults.has(Fault::HeartbeatLostOnStateChange) {
            self.heartbeat.stop();
        }
    }

    fn reset(&mut self, now: Timestamp, order: Order) {
        let keeps = self.faults.has(Fault::NmtResetCommunicationKeepsParameters);
        match order {
            Order::ResetCommunication if keeps => self.initialise(now, Groups::NONE),
            Order::ResetCommunication => self.initialise(now, Groups::COMMUNICATION),
            _ if self.faults.has(Fault::NmtResetNodeKeepsParameters) => self.initialise(now, Groups::NONE),
            _ => {
                self.take_stored_node_id();
                self.initialise(now, Groups::ALL);
            }
        }
    }

    /// Node-ID and bit rate that were stored act from a reset node on.
    fn take_stored_node_id(&mut self) {
        let Some(at) = self.objects.model.sheet().network.node_id_object else { return };
        if let Some(stored) = self.store.number(at, &self.objects.parameters) {
            self.node = u8::try_from(stored).ok().and_then(NodeId::new);
        }
    }

    fn on_nmt(&mut self, now: Timestamp, frame: &Frame) {
        let Some(node) = self.node else { return };
        // An NMT message has two bytes (CiA 301); others are ignored.
        let message = match *frame.data() {
            [command] if self.faults.has(Fault::NmtShortFrameObeyed) => {
                nmt_wire::Nmt { command: nmt_wire::Command(command), node: node.raw() }
            }
            [_, _] => match nmt_wire::Nmt::read(frame.data()) {
                Ok(message) => message,
                Err(_) => return,
            },
            _ => return,
        };
        match nmt::order(message, node, self.phase, self.faults) {
            Some(Order::Enter(phase)) => self.enter(now, phase),
            Some(order) => self.reset(now, order),
            None => {}
        }
    }

    fn on_sdo(&mut self, now: Timestamp, frame: &Frame) {
        if !self.phase.serves(Service::Sdo, self.faults) {
            return;
        }
        self.sdo.handle(now, frame, &mut self.objects);
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
        self.find_errors();
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.on_change(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    fn find_errors(&mut self) {
        let Objects { parameters, errors, encoder, .. } = &mut self.objects;
        if let (Some(low), Some(high)) = (parameters.number(0x2120, 2), parameters.number(0x2120, 3)) {
            let (low, high) = (low as u8, high as u8);
            let outside = !(low..=high).contains(&TEMPERATURE);
            errors.set(Condition::Temperature { now: TEMPERATURE, low, high }, outside);
        }
        if let Some(encoder) = encoder {
            errors.set(Condition::Overspeed, encoder.warnings() != 0);
        }
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

    fn on_sync(&mut self, now: Timestamp) {
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.on_sync(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    fn on_remote(&mut self, now: Timestamp, can_id: u16, node: NodeId) {
        if can_id == error_control::CAN_ID_BASE + u16::from(node.raw()) {
            // Heartbeat and guarding exclude each other, and heartbeat wins (CiA 301, 7.2.8.2.2).
            let guarded = self.objects.model.sheet().network.node_guarding && !self.heartbeat.is_active();
            if guarded && self.phase.is_running() {
                let answer = self.guarding.answer(now, self.phase, self.faults);
                self.send_error_control(answer);
                self.on_guarded(now, Guarded::Back);
            }
        } else if let Some(tpdo) = self.tpdos.iter_mut().find(|tpdo| tpdo.uses(can_id))
            && let Some(frame) = tpdo.on_remote(now, &self.objects)
        {
            push(&mut self.outbox, frame);
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

    fn on_lss(&mut self, now: Timestamp, frame: &Frame) {
        let network = &self.objects.model.sheet().network;
        let state = self.phase.state();
        let works = network.lss_states.is_empty()
            || self.phase == Phase::Unconfigured
            || network.lss_states.iter().any(|name| state.name() == Some(name));
        let booting = matches!(self.phase, Phase::Initialising { .. });
        let Ok(request) = lss::Request::read(frame.data()) else { return };
        if !network.lss || !works || booting || frame.len() != 8 {
            return;
        }
        let address = [1, 2, 3, 4].map(|sub| self.objects.parameters.number_or_zero(0x1018, sub) as u32);
        let node = self.node.map_or(lss_slave::UNCONFIGURED, NodeId::raw);
        let model = self.objects.model.clone();
        let (response, effect) = self.lss.handle(request, address, node, &model, self.faults);
        if let Some(response) = response {
            push(&mut self.outbox, response.to_frame(lss::SLAVE_CAN_ID));
        }
        match effect {
            Some(lss_slave::Effect::Store) => self.store_lss(),
            Some(lss_slave::Effect::Leave) => self.leave_lss(now),
            None => {}
        }
    }

    fn store_lss(&mut self) {
        let sheet = self.objects.model.sheet();
        let code = self.lss.pending.bit_timing;
        let rate = code.and_then(|code| sheet.bit_rates.iter().find(|rate| rate.lss_code == Some(code)));
        let node_id = self.lss.pending.node_id.map(u64::from);
        let rate = rate.and_then(|rate| rate.object_code).map(u64::from);
        for (at, number) in [(sheet.network.node_id_object, node_id), (sheet.network.bit_rate_object, rate)] {
            if let (Some(at), Some(number)) = (at, number) {
                self.store.save_number(at, number, &self.objects.parameters);
            }
        }
    }

    /// The manual: after "switch to waiting" the device restarts by itself, with its new settings.
    fn leave_lss(&mut self, now: Timestamp) {
        if let Some(node_id) = self.lss.pending.node_id.take() {
            self.node = NodeId::new(node_id);
            self.lss = LssSlave::new();
            self.initialise(now, Groups::ALL);
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

    /// Puts into the outbox what has become ready: after every event, so that nothing stays due.
    fn hand_out(&mut self, now: Timestamp) {
        while let Some(frame) = self.poll_emcy(now) {
            push(&mut self.outbox, frame);
        }
        if let Some(node) = self.node {
            while let Some(frame) = self.sdo.poll(now, node) {
                push(&mut self.outbox, frame);
            }
        }
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

/// The temperature of the sensor as 2120h counts it: degrees Celsius plus 64.
const TEMPERATURE: u8 = 0x56;

fn push(outbox: &mut VecDeque<Frame>, frame: Frame) {
    if outbox.len() < LONGEST_OUTBOX {
        outbox.push_back(frame);
    }
}

/// Which service a frame of the device itself belongs to.
fn service_of(frame: &Frame, node: Option<NodeId>, tpdos: &[Tpdo]) -> Option<Service> {
    let (can_id, node) = (frame.id().as_standard()?, u16::from(node?.raw()));
    Some(match can_id {
        _ if tpdos.iter().any(|tpdo| tpdo.uses(can_id)) => Service::Pdo,
        lss::SLAVE_CAN_ID => Service::Lss,
        id if id == error_control::CAN_ID_BASE + node => Service::ErrorControl,
        id if id == sdo::RESPONSE_BASE + node => Service::Sdo,
        _ => Service::Emcy,
    })
}

impl Machine for Device {
    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        let Some(can_id) = frame.id().as_standard() else { return };
        if frame.is_remote() {
            if let Some(node) = self.node {
                self.on_remote(now, can_id, node);
            }
            return;
        }
        if frame.cob_id().is_none() {
            return;
        }
        let node = self.node.map(|node| u16::from(node.raw()));
        match can_id {
            _ if node.is_some_and(|node| can_id == sdo::REQUEST_BASE + node) => self.on_sdo(now, frame),
            nmt_wire::CAN_ID => self.on_nmt(now, frame),
            lss::MASTER_CAN_ID => self.on_lss(now, frame),
            0x701..=0x77F => {
                if let Some(change) = self.consumer.on_heartbeat(now, (can_id & 0x7F) as u8) {
                    self.on_guarded(now, change);
                }
            }
            id if u64::from(id) == self.objects.parameters.number_or_zero(0x1005, 0) & 0x7FF => self.on_sync(now),
            _ => {}
        }
        self.hand_out(now);
    }

    fn poll_transmit(&mut self, _: Timestamp) -> Option<Frame> {
        self.outbox.pop_front()
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        let boot = match self.phase {
            Phase::Initialising { until } => until,
            Phase::Unconfigured => return None,
            _ => Timestamp::MAX,
        };
        let services = [
            self.heartbeat.timeout(),
            self.consumer.timeout(),
            self.guarding.timeout(),
            self.store.timeout(),
            self.sdo.timeout(),
            self.emcy_timeout(),
        ];
        let services = services.into_iter().chain(self.tpdos.iter().map(Tpdo::timeout));
        let next = services.fold(boot, Timestamp::min);
        (next < Timestamp::MAX).then_some(next)
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if let Phase::Initialising { until } = self.phase {
            if now >= until {
                self.boot_up(now);
                self.hand_out(now);
            }
            return;
        }
        if let Some(heartbeat) = self.heartbeat.poll(now, self.phase, self.faults) {
            self.send_error_control(heartbeat);
        }
        if let Some(node) = self.node {
            self.store.finish(now, &self.objects.parameters, self.objects.encoder.as_ref(), node);
        }
        self.sdo.expire(now, &self.objects);
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.poll(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
        if let Some(change) = self.consumer.poll(now) {
            self.on_guarded(now, change);
        }
        if self.guarding.is_lost(now) {
            self.on_guarded(now, Guarded::Lost);
        }
        self.hand_out(now);
    }

    fn withdraws(&self, pending: &Frame) -> bool {
        service_of(pending, self.node, &self.tpdos).is_some_and(|service| !self.phase.serves(service, self.faults))
    }
}
