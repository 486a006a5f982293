//! Which frame goes to which service, and what goes out when.

use super::heartbeat_consumer::Guarded;
use super::nmt::{Phase, Service};
use super::tpdo::Tpdo;
use super::{Device, push};
use crate::Machine;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::{error_control, lss, nmt as nmt_wire, sdo};
use canvass_traces::{Frame, Timestamp};

impl Device {
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

    fn on_sync(&mut self, now: Timestamp) {
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.on_sync(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    /// Puts into the outbox what has become ready: after every event, so that nothing stays due.
    pub(super) fn hand_out(&mut self, now: Timestamp) {
        while let Some(frame) = self.poll_emcy(now) {
            push(&mut self.outbox, frame);
        }
        if let Some(node) = self.node {
            while let Some(frame) = self.sdo.poll(now, node) {
                push(&mut self.outbox, frame);
            }
        }
    }
}

/// The CAN-ID of SYNC as delivered.
const SYNC: u64 = canvass_analyzer::wire::sync::CAN_ID as u64;

/// Which service a frame of the device itself belongs to.
pub(super) fn service_of(frame: &Frame, node: Option<NodeId>, tpdos: &[Tpdo]) -> Option<Service> {
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
            // Without 1005h it is the predefined CAN-ID.
            id if u64::from(id) == self.objects.parameters.number(0x1005, 0).unwrap_or(SYNC) & 0x7FF => {
                self.on_sync(now)
            }
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
            self.shaft_due,
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
        if now >= self.shaft_due {
            self.find_errors(now);
            self.watch_shaft(now);
        }
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
