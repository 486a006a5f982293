//! From power-on and reset to operational and back: what a change of the NMT state does to the services.

use super::dispatch::service_of;
use super::encoder::Encoder;
use super::guarding::NodeGuarding;
use super::lss_slave::LssSlave;
use super::nmt::{self, Order, Phase, Service};
use super::store::Groups;
use super::tpdo::Tpdo;
use super::{Device, PLACEHOLDER, heartbeat};
use crate::Fault;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::nmt as nmt_wire;
use canvass_traces::{Frame, Timestamp};

impl Device {
    /// Off and on again: what was not stored is lost.
    pub fn power_cycle(&mut self, now: Timestamp) {
        self.objects.errors.clear_history();
        self.lss = LssSlave::new();
        self.reset(now, Order::ResetNode);
    }

    /// Begins to initialise, with the stored values of those groups.
    pub(super) fn initialise(&mut self, now: Timestamp, groups: Groups) {
        self.outbox.clear();
        self.heartbeat.stop();
        self.guarding = NodeGuarding::new();
        self.sdo.boot();
        self.objects.errors.reset();
        self.objects.written.clear();
        self.objects.wedged = false;
        self.shaft_due = Timestamp::MAX;
        self.tpdos.iter_mut().for_each(Tpdo::stop);
        let node = self.node.unwrap_or(PLACEHOLDER);
        self.store.load(groups, &mut self.objects.parameters, self.objects.encoder.as_mut(), node);
        self.phase = match self.node {
            Some(_) => Phase::Initialising { until: now + self.objects.model.sheet().timing.boot() },
            None => Phase::Unconfigured,
        };
    }

    /// The end of initialisation.
    pub(super) fn boot_up(&mut self, now: Timestamp) {
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
        self.watch_shaft(now);
        if self.faults.has(Fault::TpdoInPreOperational) {
            self.start_tpdos(now);
        }
        if Encoder::starts_in_operational(&self.objects.parameters) {
            self.enter(now, Phase::Operational);
        }
    }

    /// Another NMT state: services that don't work in it end.
    pub(super) fn enter(&mut self, now: Timestamp, phase: Phase) {
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
        self.node = match self.store.number(at, &self.objects.parameters) {
            Some(stored) => u8::try_from(stored).ok().and_then(NodeId::new),
            None => self.delivered_node,
        };
    }

    /// An NMT message came.
    pub(super) fn on_nmt(&mut self, now: Timestamp, frame: &Frame) {
        let Some(node) = self.node else { return };
        // An NMT message has two bytes (CiA 301); others are ignored.
        let message = match *frame.data() {
            [command] if self.faults.has(Fault::NmtShortFrameObeyed) => {
                nmt_wire::Nmt { command: nmt_wire::Command(command), node: node.raw() }
            }
            [command, node] => nmt_wire::Nmt { command: nmt_wire::Command(command), node },
            _ => return,
        };
        match nmt::order(message, node, self.phase, self.faults) {
            Some(Order::Enter(phase)) => self.enter(now, phase),
            Some(order) => self.reset(now, order),
            None => {}
        }
    }
}
