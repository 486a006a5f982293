//! The loop over the services: routes frames and events to them, and collects their frames.

use super::Device;
use super::lss_slave;
use super::mischief::Incoming;
use super::nmt::{Phase, Service};
use super::routes::{Route, Routes};
use super::sdo_channels::is_plain_upload;
use super::service::{Event, Service as _};
use crate::Fault;
use canvass_analyzer::NodeId;
use canvass_analyzer::wire::{error_control, lss};
use canvass_bus::Machine;
use canvass_traces::{Frame, Timestamp};

impl Device {
    fn on_data(&mut self, now: Timestamp, route: Route, frame: &Frame) {
        let (services, context) = (&mut self.services, &mut self.context);
        match route {
            Route::Others => {}
            Route::Nmt => services.nmt.handle(now, route, frame, context),
            Route::Sdo | Route::FurtherSdo(_) => services.sdo.handle(now, route, frame, context),
            Route::Rpdo(_) => services.rpdos.handle(now, route, frame, context),
            Route::Sync => services.sync.handle(now, route, frame, context),
            Route::Time => services.time.handle(now, route, frame, context),
            Route::Lmt => services.lmt.handle(now, route, frame, context),
            Route::Lss => services.lss.handle(now, route, frame, context),
            Route::PeerEmcy => services.emcy.handle(now, route, frame, context),
            Route::PeerErrorControl => services.consumer.handle(now, route, frame, context),
        }
        self.follow_up(now);
    }

    fn on_remote(&mut self, now: Timestamp, can_id: u16, node: NodeId) {
        let (services, context) = (&mut self.services, &mut self.context);
        if can_id == error_control::CAN_ID_BASE + u16::from(node.raw()) {
            services.guarding.on_request(now, context);
        } else if !services.tpdos.on_remote(now, can_id, context)
            && context.has(Fault::RemoteFrameTakenAsRpdo)
            && let Route::Rpdo(position) = self.routes.of(can_id)
        {
            services.rpdos.receive(now, position, &[0; 8], context);
        }
        self.follow_up(now);
    }

    /// Delivers the queued events to the services, and carries out requests to the device.
    pub(super) fn follow_up(&mut self, now: Timestamp) {
        while let Some(event) = self.context.events.pop_front() {
            match event {
                Event::Act => self.act_on_writes(now),
                Event::Order(order) => self.obey(now, order),
                event => self.deliver(now, event),
            }
        }
    }

    /// Handles all writes since the last call.
    fn act_on_writes(&mut self, now: Timestamp) {
        let mut any = false;
        while let Some((at, value)) = self.context.objects.written.pop() {
            self.deliver(now, Event::Written(at, value));
            any = true;
        }
        if any {
            self.deliver(now, Event::Changed);
        }
    }

    /// Recomputes all routes after a change of a COB-ID or the node-ID.
    pub(super) fn find_routes(&mut self) {
        self.context.routes_changed = false;
        self.routes = Routes::new();
        self.services.find_routes(&self.context, &mut self.routes);
    }

    /// Moves ready frames to the outbox, and computes the time of the next event. The device calls this after every
    /// event.
    pub(super) fn settle(&mut self, now: Timestamp) {
        if self.context.routes_changed {
            self.find_routes();
        }
        self.services.transmit(now, &mut self.context);
        self.beside_sdo = Timestamp::ZERO;
        self.wake = match self.context.phase {
            Phase::Unconfigured => self.activation_timeout().min(self.services.lss.timeout(&self.context)),
            // Services settle their waiting work when they start again after the reset.
            Phase::Initialising { until } => {
                let ready = self.services.emcy.timeout(&self.context).min(self.services.sdo.next());
                until.min(self.activation_timeout()).min(ready)
            }
            _ if self.context.silent_until > Timestamp::ZERO => self.context.silent_until,
            _ => {
                self.beside_sdo = self.activation_timeout().min(self.services.timeout(&self.context));
                self.beside_sdo.min(self.services.sdo.next())
            }
        };
    }

    /// As [`Device::settle`], after an event that changed only the SDO servers.
    fn settle_sdo(&mut self, now: Timestamp) {
        if self.beside_sdo == Timestamp::ZERO {
            return self.settle(now);
        }
        self.services.sdo.transmit(now, &mut self.context);
        self.wake = self.beside_sdo.min(self.services.sdo.next());
    }

    /// The service that sent this frame of the device.
    pub(super) fn service_of(&self, frame: &Frame) -> Option<Service> {
        let (can_id, node) = (frame.id().as_standard()?, self.context.node?);
        let clock = &self.context.objects.clock;
        Some(match can_id {
            _ if self.services.tpdos.use_id(can_id) => Service::Pdo,
            lss::SLAVE_CAN_ID => Service::Lss,
            id if id == error_control::CAN_ID_BASE + u16::from(node.raw()) => Service::ErrorControl,
            id if self.services.sdo.responds_with(id, node) => Service::Sdo,
            id if id == self.services.sync.own_can_id() || id == clock.own_can_id() => Service::Broadcast,
            _ => Service::Emcy,
        })
    }

    /// Whether the window of a waiting synchronous PDO has closed.
    fn is_too_late(&self, pending: &Frame) -> bool {
        let can_id = pending.id().as_standard();
        self.context.sync_closed && can_id.is_some_and(|id| self.services.tpdos.use_synchronously(id))
    }

    /// Passes a received frame to the service of its CAN-ID. A remote frame is handled by its CAN-ID alone.
    fn receive(&mut self, now: Timestamp, frame: &Frame) {
        let confuses = self.context.has(Fault::ExtendedFrameObeyed);
        let standard = frame.id().as_standard();
        let Some(can_id) = standard.or_else(|| confuses.then(|| frame.id().raw() as u16 & 0x7FF)) else { return };
        if self.hangs || now < self.context.silent_until {
            return;
        }
        if frame.is_remote() {
            if let Some(node) = self.context.node {
                self.on_remote(now, can_id, node);
                self.settle(now);
            }
            return;
        }
        let route = self.routes.of(can_id);
        if route == Route::Others || frame.is_error() || frame.is_fd() || frame.is_xl() {
            return;
        }
        if self.overload.on_frame(now, self.context.firmware()) {
            // The watchdog resets the processor.
            self.reset_node(now);
        } else if route == Route::Sdo && is_plain_upload(frame) {
            self.services.sdo.handle(now, route, frame, &mut self.context);
            return self.settle_sdo(now);
        } else {
            self.on_data(now, route, frame);
        }
        self.settle(now);
    }
}

impl Machine for Device {
    fn ignores(&self, frame: &Frame) -> bool {
        let is_others = |can_id| self.routes.of(can_id) == Route::Others;
        !self.mischief.is_active() && frame.cob_id().is_some_and(is_others)
    }

    fn handle(&mut self, now: Timestamp, frame: &Frame) {
        if !self.mischief.is_active() {
            self.receive(now, frame);
            return;
        }
        match self.mischief.on_receive(frame, self.context.node, lss_slave::address(&self.context.objects.parameters)) {
            Incoming::Frames(first, second) => {
                self.receive(now, &first);
                second.iter().for_each(|second| self.receive(now, second));
            }
            Incoming::Lost => {}
            Incoming::Answered(answer) => self.context.send(answer),
        }
    }

    fn poll_transmit(&mut self, _: Timestamp) -> Option<Frame> {
        if self.activation.is_some() {
            return None;
        }
        if !self.mischief.is_active() {
            return self.context.outbox.pop_front();
        }
        loop {
            let frame = self.context.outbox.pop_front()?;
            if let Some(frame) = self.mischief.on_send(frame, self.context.node) {
                return Some(frame);
            }
        }
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        (self.wake < Timestamp::MAX && !self.hangs).then_some(self.wake)
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if now < self.beside_sdo {
            self.services.sdo.poll(now, &mut self.context);
            return self.settle_sdo(now);
        }
        self.go_on_with_activation(now);
        match self.context.phase {
            Phase::Initialising { until } if now >= until => self.boot_up(now),
            Phase::Initialising { .. } => self.services.sdo.poll(now, &mut self.context),
            Phase::Unconfigured => self.services.lss.poll(now, &mut self.context),
            _ if now < self.context.silent_until => {}
            _ => {
                if self.context.silent_until > Timestamp::ZERO {
                    self.context.silent_until = Timestamp::ZERO;
                    self.deliver(now, Event::Resumed);
                }
                self.poll_services(now);
            }
        }
        self.settle(now);
    }

    fn bit_rate(&self) -> Option<u32> {
        self.bit_rate
    }

    fn power_cycle(&mut self, now: Timestamp) {
        Self::power_cycle(self, now);
    }

    fn duplicate(&self) -> Option<Box<dyn Machine>> {
        Some(Box::new(self.clone()))
    }

    fn withdraws(&self, pending: &Frame) -> bool {
        let silent = self.activation.is_some() || self.hangs;
        silent
            || self.is_too_late(pending)
            || self.service_of(pending).is_some_and(|service| !self.context.serves(service))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faults;
    use crate::models::Model;
    use canvass_traces::{CanId, Duration};

    /// A reset ends the wait for a heartbeat. Otherwise the wait would be due during initialisation, where nobody
    /// handles it, and the device would wake up without end.
    #[test]
    fn nothing_wakes_a_device_that_initialises() {
        let model = Model::by_id("reference-301").unwrap();
        let mut device = Device::new(model, NodeId::new(10), Faults::NONE, 0);
        let frame = |id, data: &[u8]| Frame::new(CanId::standard_masked(id), data).unwrap();
        let booted = device.poll_timeout().unwrap();
        device.handle_timeout(booted);
        // The consumer time for node 11 is set to 50 ms, and node 11 sends one heartbeat.
        device.handle(booted, &frame(0x60A, &[0x23, 0x16, 0x10, 0x01, 50, 0, 11, 0]));
        device.handle(booted, &frame(0x70B, &[5]));
        let reset = booted + Duration::from_millis(1);
        device.handle(reset, &frame(0, &[0x81, 10]));
        let next = device.poll_timeout().unwrap();
        assert!(next > reset + Duration::from_millis(50), "{next}");
        device.handle_timeout(next);
        assert_eq!(std::iter::from_fn(|| device.poll_transmit(next)).last(), Some(frame(0x70A, &[0])));
        assert!(device.poll_timeout().is_none_or(|later| later > next && later < Timestamp::MAX));
    }
}
