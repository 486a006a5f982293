//! The life cycle of a device: power-on, resets, NMT states.

use super::clock::Clock;
use super::condition::Condition;
use super::lmt_slave::LmtSlave;
use super::lss_slave::LssSlave;
use super::nmt::{Order, Phase};
use super::objects::Objects;
use super::overload::Overload;
use super::parameters::Content;
use super::service::Event;
use super::store::Groups;
use super::{Device, PLACEHOLDER};
use crate::models::Trigger;
use crate::{Fault, Liberty};
use canvass_analyzer::NodeId;
use canvass_analyzer::object;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::emcy::{self, Emcy, EmcyCode, ErrorRegister};
use canvass_analyzer::wire::error_control::{ErrorControl, State};
use canvass_traces::{Frame, Timestamp};

impl Device {
    /// Switches off and on: values that were not stored are lost.
    pub fn power_cycle(&mut self, now: Timestamp) {
        let context = &mut self.context;
        context.objects.errors.power_on();
        context.store.power_on();
        context.objects.clock = Clock::new(now, &context.objects.firmware);
        context.objects.received_emcy = 0;
        self.services.lmt = LmtSlave::new();
        self.services.lss = LssSlave::new();
        self.services.sdo.power_on();
        self.overload = Overload::new();
        self.hangs = false;
        self.resets = 0;
        self.take_stored_node_id();
        self.take_stored_bit_rate();
        self.initialise(now, Groups::ALL);
        self.settle(now);
    }

    /// Carries out a request of a service to the device.
    pub(super) fn obey(&mut self, now: Timestamp, order: Order) {
        let resets = matches!(order, Order::ResetCommunication | Order::ResetNode);
        let hangs = self.context.phase == Phase::Stopped && self.context.has(Fault::ResetWhenStoppedHangs);
        match if resets && hangs { Order::Hang } else { order } {
            Order::Enter(phase) => self.enter(now, phase),
            Order::ResetCommunication => self.reset_communication(now),
            Order::ResetNode => self.reset_node(now),
            Order::Restart { node, bit_timing } => {
                self.context.node = node;
                self.use_bit_rate(bit_timing);
                self.initialise(now, Groups::ALL);
            }
            Order::MoveTo(node) => {
                self.context.node = Some(node);
                let outbox = std::mem::take(&mut self.context.outbox);
                self.initialise(now, Groups::ALL);
                self.context.outbox = outbox;
            }
            Order::ActivateBitRate { bit_timing, delay } => self.activate_bit_rate(now, bit_timing, delay),
            Order::Hang => {
                self.hangs = true;
                self.context.outbox.clear();
            }
        }
    }

    /// Begins initialisation with the stored values of these groups.
    pub(super) fn initialise(&mut self, now: Timestamp, groups: Groups) {
        if self.context.node.is_none() && self.context.has(Fault::UnconfiguredNodeBoots) {
            self.context.node = Some(PLACEHOLDER);
        }
        self.activation = None;
        self.context.clear();
        self.deliver(now, Event::Initialise);
        self.load(groups);
        self.context.phase = match self.context.node {
            Some(_) => Phase::Initialising { until: now + self.context.objects.model.sheet().timing.boot() },
            None => Phase::Unconfigured,
        };
        self.deliver(now, Event::Loaded);
        self.find_routes();
        if let Some(node) = self.context.node
            && self.context.has(Fault::EmcyBeforeBootUp)
        {
            let none = Emcy::new(EmcyCode::NO_ERROR, ErrorRegister(0), [0; 5]);
            self.context.send(none.to_frame(emcy::CAN_ID_BASE + u16::from(node.raw())));
        }
    }

    /// Loads the stored values of these groups, or their defaults.
    fn load(&mut self, groups: Groups) {
        let node = self.context.node_or_placeholder();
        let super::Context { objects, store, .. } = &mut self.context;
        if objects.has(Fault::StoreTornByReset) {
            store.tear(&objects.parameters, node);
        }
        store.load(groups, &mut objects.parameters, node);
        if let Some(application) = objects.application.as_mut().filter(|_| groups.contains(Groups::APPLICATION)) {
            application.restore(store.retained().unwrap_or(0));
        }
        if objects.has(Fault::ConfigurationDateLost) {
            objects.parameters.set_number(object::VERIFY_CONFIGURATION, 1, 0);
            objects.parameters.set_number(object::VERIFY_CONFIGURATION, 2, 0);
        }
        if objects.has(Fault::ParameterDriftsAtReset) {
            objects.parameters.set_number(object::INHIBIT_TIME_EMCY, 0, u64::from(self.resets));
        }
        objects.settle_links(groups);
        self.show_node_id();
    }

    fn send_boot_up(&mut self) {
        let firmware = *self.context.firmware();
        let wrong = firmware.has(Fault::BootUpWrongData);
        let message = if wrong { ErrorControl::heartbeat(State::PRE_OPERATIONAL) } else { ErrorControl::BOOT_UP };
        if !firmware.has(Fault::BootUpMissing) {
            let count = if firmware.has(Fault::BootUpTwice) { 2 } else { 1 };
            (0..count).for_each(|_| self.context.send_error_control(message));
        }
    }

    /// Ends initialisation.
    pub(super) fn boot_up(&mut self, now: Timestamp) {
        self.context.phase = Phase::PreOperational;
        self.resets += 1;
        let missing = self.resets.is_multiple_of(8) && self.context.has(Fault::BootUpSometimesMissing);
        if self.context.objects.model.sheet().network.boot_up_message && !missing {
            self.send_boot_up();
        }
        self.deliver(now, Event::Started);
        self.find_routes();
        self.deliver(now, Event::Changed);
        let failed_before = self.context.refuses_operational;
        self.context.refuses_operational =
            std::mem::take(&mut self.context.breaks_next_start) || self.context.has(Fault::NmtStartRefusedInError);
        let (code, register) = (EmcyCode(0x5000), ErrorRegister::GENERIC.0);
        if failed_before || self.context.refuses_operational {
            let hardware = Condition::Hardware { code, register, bytes: [0; 5] };
            self.context.report(hardware, self.context.refuses_operational);
        }
        if self.context.refuses_operational {
            return;
        }
        let objects = &self.context.objects;
        let application = objects.application.as_ref();
        if application.is_some_and(|application| application.starts_in_operational(&objects.surroundings()))
            || self.starts_by_itself()
        {
            self.enter(now, Phase::Operational);
        }
    }

    /// Whether the device enters operational without the NMT master, by 1F80h or local control.
    fn starts_by_itself(&self) -> bool {
        if self.context.takes(Liberty::SelfStart) {
            return true;
        }
        let start_up = self.context.objects.model.sheet().network.start_up;
        let set = self.context.objects.parameters.number(object::NMT_STARTUP, 0);
        set.is_some_and(|value| value as u32 & start_up.mask == start_up.value)
            && !self.context.has(Fault::StartUpIgnored)
    }

    /// Enters another NMT state, and ends the services that don't work in that state.
    fn enter(&mut self, now: Timestamp, phase: Phase) {
        if self.context.phase == phase {
            return;
        }
        let before = std::mem::replace(&mut self.context.phase, phase);
        self.deliver(now, Event::Entered { before });
        let waiting = std::mem::take(&mut self.context.outbox);
        let served = |frame: &Frame| self.service_of(frame).is_none_or(|service| self.context.serves(service));
        self.context.outbox = waiting.into_iter().filter(served).collect();
    }

    fn reset_communication(&mut self, now: Timestamp) {
        // A node-ID configured by LSS takes effect at the next reset communication (CiA 305).
        self.take_pending_node_id();
        let firmware = self.context.firmware();
        let groups = match () {
            () if firmware.has(Fault::NmtResetCommunicationKeepsParameters) => Groups::NONE,
            () if self.context.objects.model.sheet().quirks.reset_communication_loads_all => {
                self.take_written_bit_rate();
                Groups::ALL.without(Groups::BUS)
            }
            () if firmware.has(Fault::NmtResetCommunicationRestoresAll) => Groups::ALL,
            () => Groups::COMMUNICATION,
        };
        self.initialise(now, groups);
    }

    pub(super) fn reset_node(&mut self, now: Timestamp) {
        if self.context.has(Fault::NmtResetNodeKeepsParameters) {
            return self.initialise(now, Groups::NONE);
        }
        if self.context.has(Fault::LssNodeIdStoredAtOnce) {
            self.take_pending_node_id();
            return self.initialise(now, Groups::ALL);
        }
        self.services.lss.pending = Default::default();
        let model = self.context.objects.model.clone();
        let (network, quirks) = (&model.sheet().network, &model.sheet().quirks);
        if quirks.bus_objects_survive_reset {
            self.take_written_node_id();
            self.take_written_bit_rate();
            return self.initialise(now, Groups::ALL.without(Groups::BUS));
        }
        if network.takes_effect.contains(&Trigger::ResetNode) {
            self.take_stored_node_id();
            self.take_stored_bit_rate();
        }
        let kept = match self.context.takes(Liberty::VariablesKept) {
            true => Groups::MANUFACTURER,
            false => Groups::NONE,
        };
        self.initialise(now, Groups::ALL.without(kept));
        if quirks.reset_node_restores_profile {
            self.context.objects.parameters.restore_profile(self.context.node_or_placeholder());
        }
    }

    /// Sets a read-only node-ID object to the current node-ID, which may differ from the stored node-ID.
    fn show_node_id(&mut self) {
        let objects = &mut self.context.objects;
        let Some(at) = objects.model.sheet().network.node_id_object else { return };
        let is_shown = objects.parameters.entry(at).is_ok_and(|entry| !entry.writable);
        if let (true, Some(node)) = (is_shown, self.context.node) {
            objects.parameters.set(at, Content::Number(u64::from(node.raw())));
        }
    }

    /// Applies a written node-ID that takes effect without being stored.
    fn take_written_node_id(&mut self) {
        let Objects { model, parameters, .. } = &self.context.objects;
        let written = model.sheet().network.node_id_object.and_then(|at| parameters.number(at.index.0, at.sub.0));
        if let Some(node) = written.and_then(|written| u8::try_from(written).ok()).and_then(NodeId::new) {
            self.context.node = Some(node);
        }
    }

    fn take_pending_node_id(&mut self) {
        if let Some(node_id) = self.services.lss.pending.node_id.take() {
            self.context.node = NodeId::new(node_id);
        }
    }

    /// Applies the stored node-ID, or the delivered node-ID if none is stored.
    fn take_stored_node_id(&mut self) {
        let super::Context { objects, store, .. } = &self.context;
        let stored = match objects.model.sheet().network.node_id_object {
            Some(at) => store.number(at, &objects.parameters),
            None => store.network().node_id.map(u64::from),
        };
        self.context.node = match stored {
            Some(stored) => u8::try_from(stored).ok().and_then(NodeId::new),
            None => self.delivered_node,
        };
    }
}
