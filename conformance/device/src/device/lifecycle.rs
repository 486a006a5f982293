//! From power-on and reset to operational and back: what a change of the NMT state does to the services.

use super::clock::Clock;
use super::encoder::Encoder;
use super::lss_slave::LssSlave;
use super::nmt::{self, Order, Phase, Service};
use super::overload::Overload;
use super::parameters::Content;
use super::rpdo::Rpdo;
use super::second_sdo::SecondSdo;
use super::store::Groups;
use super::tpdo::Tpdo;
use super::{Device, PLACEHOLDER, push};
use crate::models::Trigger;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::{Wire, nmt as nmt_wire};
use canvass_traces::{Duration, Frame, Timestamp};

/// NMT commands that follow each other faster than that are too much for a firmware that keeps only one.
const ONE_COMMAND: Duration = Duration::from_millis(1);

impl Device {
    /// Off and on again: what was not stored is lost.
    pub fn power_cycle(&mut self, now: Timestamp) {
        self.objects.errors.power_on();
        self.lmt.power_on();
        self.store.power_on();
        self.objects.clock = Clock::new(now, &self.firmware);
        self.objects.received_emcy = 0;
        self.lss = LssSlave::new();
        self.overload = Overload::new();
        self.hangs = false;
        self.resets = 0;
        self.take_stored_node_id();
        self.take_stored_bit_rate();
        self.initialise(now, Groups::ALL);
        self.settle(now);
    }

    /// A watchdog resets the processor.
    pub(super) fn restart(&mut self, now: Timestamp) {
        self.reset(now, Order::ResetNode);
    }

    /// The firmware does nothing any more.
    pub(super) fn hang(&mut self) {
        self.hangs = true;
        self.outbox.clear();
    }

    /// Begins to initialise, with the stored values of those groups.
    pub(super) fn initialise(&mut self, now: Timestamp, groups: Groups) {
        if self.node.is_none() && self.firmware.boots_without_node_id() {
            self.node = Some(PLACEHOLDER);
        }
        self.outbox.clear();
        self.activation = None;
        self.heartbeat.stop();
        self.guarding.reset(&self.firmware);
        if self.firmware.ends_transfer_at_reset() {
            self.sdo.boot();
        }
        self.second_sdos.iter_mut().for_each(SecondSdo::reset);
        self.objects.errors.reset();
        self.objects.written.clear();
        self.objects.wedged = false;
        self.shaft_due = Timestamp::MAX;
        self.objects.drop_waiting();
        self.silent_until = Timestamp::ZERO;
        self.tpdos.iter_mut().for_each(Tpdo::stop);
        self.rpdos.iter_mut().for_each(Rpdo::stop);
        let node = self.node.unwrap_or(PLACEHOLDER);
        if self.firmware.tears_store_at_reset() {
            self.store.tear(&self.objects.parameters, node);
        }
        self.store.load(groups, &mut self.objects.parameters, self.objects.encoder.as_mut(), node);
        self.spoil_parameters();
        self.objects.settle_links(groups);
        self.show_node_id();
        self.phase = match self.node {
            Some(_) => Phase::Initialising { until: now + self.objects.model.sheet().timing.boot() },
            None => Phase::Unconfigured,
        };
        self.second_sdos.iter_mut().for_each(|channel| channel.configure(&self.objects));
        self.find_routes();
        if self.node.is_some() && self.firmware.sends_emcy_before_boot_up() {
            let none = Emcy::new(EmcyCode::NO_ERROR, ErrorRegister(0), [0; 5]);
            push(&mut self.outbox, none.to_frame(emcy::CAN_ID_BASE + u16::from(node.raw())));
        }
    }

    /// What a faulty firmware makes of what it has loaded.
    fn spoil_parameters(&mut self) {
        if self.firmware.loses_configuration_date() {
            self.objects.parameters.set_number(0x1020, 1, 0);
            self.objects.parameters.set_number(0x1020, 2, 0);
        }
        if self.firmware.drifts_at_reset() {
            self.objects.parameters.set_number(0x1015, 0, u64::from(self.resets));
        }
    }

    /// The end of initialisation.
    pub(super) fn boot_up(&mut self, now: Timestamp) {
        self.phase = Phase::PreOperational;
        self.resets += 1;
        let missing = self.resets.is_multiple_of(8) && self.firmware.skips_some_boot_ups();
        if self.objects.model.sheet().network.boot_up_message && !missing {
            for message in self.firmware.boot_up_messages() {
                self.send_error_control(message);
            }
        }
        self.start_heartbeat(now);
        self.consumer.configure(now, &self.objects.parameters, &self.firmware);
        self.configure_guarding(now);
        self.configure_rpdos();
        self.configure_sync(now);
        self.sync.restart(now, true);
        self.configure_clock(now);
        self.find_routes();
        self.after_change(now);
        self.watch_shaft(now);
        if self.firmware.sends_pdos_in_pre_operational() {
            self.start_tpdos(now);
        }
        if Encoder::starts_in_operational(&self.objects.parameters) && self.objects.encoder.is_some()
            || self.starts_by_itself()
        {
            self.enter(now, Phase::Operational);
        }
    }

    /// 1F80h: whether the device goes to operational without its master.
    fn starts_by_itself(&self) -> bool {
        let start_up = self.objects.model.sheet().network.start_up;
        let set = self.objects.parameters.number(0x1F80, 0);
        set.is_some_and(|value| value as u32 & start_up.mask == start_up.value) && self.firmware.heeds_start_up_object()
    }

    /// Another NMT state: services that don't work in it end.
    pub(super) fn enter(&mut self, now: Timestamp, phase: Phase) {
        if self.phase == phase {
            return;
        }
        let before = std::mem::replace(&mut self.phase, phase);
        if phase.serves(Service::Pdo, &self.firmware) {
            self.start_tpdos(now);
        } else {
            self.tpdos.iter_mut().for_each(Tpdo::stop);
        }
        if !phase.receives_pdos(&self.firmware) {
            self.rpdos.iter_mut().for_each(Rpdo::stop);
        }
        if !phase.serves(Service::Sdo, &self.firmware) && self.firmware.ends_transfer_when_stopped() {
            self.sdo.reset();
            self.second_sdos.iter_mut().for_each(SecondSdo::reset);
        }
        let sends = phase.serves(Service::Broadcast, &self.firmware);
        if sends != before.serves(Service::Broadcast, &self.firmware) {
            self.sync.restart(now, sends);
            self.objects.clock.restart(now, sends);
        }
        let waiting = std::mem::take(&mut self.outbox);
        let served = |frame: &Frame| self.service_of(frame).is_none_or(|service| phase.serves(service, &self.firmware));
        self.outbox = waiting.into_iter().filter(served).collect();
        if !self.firmware.keeps_heartbeat_over_state_change() {
            self.heartbeat.stop();
        }
    }

    fn reset(&mut self, now: Timestamp, order: Order) {
        let keeps = self.firmware.reset_communication_keeps_all();
        match order {
            Order::ResetCommunication => {
                self.take_pending_node_id();
                self.initialise(
                    now,
                    match () {
                        () if keeps => Groups::NONE,
                        () if self.objects.model.sheet().quirks.reset_communication_loads_all => {
                            Groups::ALL.without(Groups::BUS)
                        }
                        () if self.firmware.reset_communication_loads_all() => Groups::ALL,
                        () => Groups::COMMUNICATION,
                    },
                );
            }
            _ if self.firmware.reset_node_keeps_all() => self.initialise(now, Groups::NONE),
            _ => self.reset_node(now),
        }
    }

    fn reset_node(&mut self, now: Timestamp) {
        if self.firmware.takes_lss_node_id_at_reset_node() {
            self.take_pending_node_id();
            return self.initialise(now, Groups::ALL);
        }
        self.lss.pending = Default::default();
        let model = self.objects.model.clone();
        let (network, quirks) = (&model.sheet().network, &model.sheet().quirks);
        if quirks.bus_objects_survive_reset {
            self.take_written_node_id();
            return self.initialise(now, Groups::ALL.without(Groups::BUS));
        }
        if network.takes_effect.contains(&Trigger::ResetNode) {
            self.take_stored_node_id();
            self.take_stored_bit_rate();
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

    /// A node-ID that LSS configured acts from a reset communication on (CiA 305).
    fn take_pending_node_id(&mut self) {
        if let Some(node_id) = self.lss.pending.node_id.take() {
            self.node = NodeId::new(node_id);
        }
    }

    /// Node-ID and bit rate that were stored act from a reset node on.
    fn take_stored_node_id(&mut self) {
        let stored = match self.objects.model.sheet().network.node_id_object {
            Some(at) => self.store.number(at, &self.objects.parameters),
            None => self.store.network().node_id.map(u64::from),
        };
        self.node = match stored {
            Some(stored) => u8::try_from(stored).ok().and_then(NodeId::new),
            None => self.delivered_node,
        };
    }

    /// An NMT message came.
    pub(super) fn on_nmt(&mut self, now: Timestamp, frame: &Frame) {
        let Some(node) = self.node else { return };
        // An NMT message has two bytes (CiA 301); others are ignored.
        let message = match *frame.data() {
            [command] if self.firmware.obeys_short_command() => {
                nmt_wire::Nmt { command: nmt_wire::Command(command), node: node.raw() }
            }
            [command, node] => nmt_wire::Nmt { command: nmt_wire::Command(command), node },
            _ => return,
        };
        let before = self.last_command.replace(now);
        let too_fast = before.is_some_and(|before| now < before + ONE_COMMAND);
        if too_fast && self.firmware.keeps_one_command_only() {
            return;
        }
        match nmt::order(message, node, self.phase, &self.firmware) {
            Some(Order::Enter(phase)) => self.enter(now, phase),
            Some(order) => self.reset(now, order),
            None => {}
        }
    }
}
