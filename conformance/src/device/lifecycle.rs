//! From power-on and reset to operational and back: what a change of the NMT state does to the services.

use super::dispatch::service_of;
use super::encoder::Encoder;
use super::lss_slave::LssSlave;
use super::nmt::{self, Order, Phase, Service};
use super::parameters::Content;
use super::store::Groups;
use super::tpdo::Tpdo;
use super::{Device, PLACEHOLDER, heartbeat};
use crate::Fault;
use crate::models::Trigger;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::nmt as nmt_wire;
use canvass_traces::{Frame, Timestamp};

impl Device {
    /// Off and on again: what was not stored is lost.
    pub fn power_cycle(&mut self, now: Timestamp) {
        self.objects.errors.power_on();
        self.lss = LssSlave::new();
        self.lmt.power_on();
        self.store.power_on();
        self.take_stored_node_id();
        self.initialise(now, Groups::ALL);
    }

    /// Begins to initialise, with the stored values of those groups.
    pub(super) fn initialise(&mut self, now: Timestamp, groups: Groups) {
        self.outbox.clear();
        self.heartbeat.stop();
        self.guarding.reset(self.faults);
        self.sdo.boot();
        self.silent_until = Timestamp::ZERO;
        self.objects.errors.reset();
        self.objects.written.clear();
        self.objects.drop_waiting();
        self.tpdos.iter_mut().for_each(Tpdo::stop);
        let node = self.node.unwrap_or(PLACEHOLDER);
        self.store.load(groups, &mut self.objects.parameters, self.objects.encoder.as_mut(), node);
        self.show_node_id();
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
            Order::ResetCommunication if self.objects.model.sheet().quirks.reset_communication_loads_all => {
                self.initialise(now, Groups::ALL.without(Groups::BUS));
            }
            Order::ResetCommunication => self.initialise(now, Groups::COMMUNICATION),
            _ if self.faults.has(Fault::NmtResetNodeKeepsParameters) => self.initialise(now, Groups::NONE),
            _ => self.reset_node(now),
        }
    }

    fn reset_node(&mut self, now: Timestamp) {
        let model = self.objects.model.clone();
        let (network, quirks) = (&model.sheet().network, &model.sheet().quirks);
        if quirks.bus_objects_survive_reset {
            self.take_written_node_id();
            return self.initialise(now, Groups::ALL.without(Groups::BUS));
        }
        if network.takes_effect.contains(&Trigger::ResetNode) {
            self.take_stored_node_id();
        }
        self.initialise(now, Groups::ALL);
        if quirks.reset_node_restores_profile {
            self.objects.parameters.restore_profile(self.node.unwrap_or(PLACEHOLDER));
        }
    }

    /// An object that can't be written shows the node-ID in use, not the one that is stored.
    fn show_node_id(&mut self) {
        let Some(at) = self.objects.model.sheet().network.node_id_object else { return };
        let is_shown = self.objects.parameters.entry(at).is_ok_and(|entry| !entry.writable);
        if let (true, Some(node)) = (is_shown, self.node) {
            self.objects.parameters.set(at, Content::Number(u64::from(node.raw())));
        }
    }

    /// A node-ID that was written acts without being stored.
    fn take_written_node_id(&mut self) {
        let at = self.objects.model.sheet().network.node_id_object;
        let written = at.and_then(|at| self.objects.parameters.number(at.index.0, at.sub.0));
        if let Some(node) = written.and_then(|written| u8::try_from(written).ok()).and_then(NodeId::new) {
            self.node = Some(node);
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
