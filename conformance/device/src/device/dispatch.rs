//! Which frame goes to which service, and what goes out when.

use super::emcy::Condition;
use super::mischief::Incoming;
use super::nmt::{Phase, Service};
use super::routes::Route;
use super::rpdo::{Payload, Received};
use super::{Device, push};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::sdo::Request;
use canvass_analyzer::wire::sync::Sync as SyncMessage;
use canvass_analyzer::wire::time::TimeOfDay;
use canvass_analyzer::wire::{error_control, lss, sdo};
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_bus::Machine;
use canvass_traces::{Frame, Timestamp};

const ERROR_REGISTER: Multiplexer = Multiplexer::new(0x1001, 0);
const READ_ERROR_REGISTER: Request = Request::upload(ERROR_REGISTER);

impl Device {
    fn on_data(&mut self, now: Timestamp, route: Route, can_id: u16, frame: &Frame) {
        match route {
            Route::Others => {}
            Route::Nmt => self.on_nmt(now, frame),
            Route::Sdo => self.on_sdo(now, frame),
            Route::SecondSdo(position) => self.on_second_sdo(now, position, frame),
            Route::Rpdo(position) => self.on_rpdo(now, position, frame.data()),
            Route::Sync => self.on_sync(now, frame.data()),
            Route::Time => self.on_time(now, frame),
            Route::Lss if self.objects.model.sheet().lmt.is_some() => self.on_lmt(now, frame),
            Route::Lss => self.on_lss(now, frame),
            Route::PeerEmcy => self.on_peer_emcy(frame),
            Route::PeerErrorControl => self.on_peer(now, (can_id & 0x7F) as u8),
        }
    }

    fn on_sdo(&mut self, now: Timestamp, frame: &Frame) {
        if self.objects.wedged {
            return;
        }
        if self.phase.serves(Service::Sdo, &self.firmware) && self.overload.on_request(&self.firmware) {
            self.sdo.handle(now, frame, &mut self.objects);
            if self.objects.wedged {
                return self.sdo.reset();
            }
            if frame.len() == 8 && Request::read(frame.data()) == Ok(READ_ERROR_REGISTER) {
                self.objects.errors.register_was_read();
            }
            self.act_on_writes(now);
        }
    }

    fn on_second_sdo(&mut self, now: Timestamp, position: u8, frame: &Frame) {
        if self.phase.serves(Service::Sdo, &self.firmware)
            && let Some(channel) = self.second_sdos.get_mut(usize::from(position))
        {
            channel.handle(now, frame, &mut self.objects);
            self.act_on_writes(now);
        }
    }

    fn on_remote(&mut self, now: Timestamp, can_id: u16, node: NodeId) {
        if can_id == error_control::CAN_ID_BASE + u16::from(node.raw()) {
            self.on_guarding_request(now);
        } else if let Some(tpdo) = self.tpdos.iter_mut().find(|tpdo| tpdo.uses(can_id)) {
            if let Some(frame) = tpdo.on_remote(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        } else if self.firmware.takes_remote_frame_for_rpdo()
            && let Route::Rpdo(position) = self.routes.of(can_id)
        {
            self.on_rpdo(now, position, &[0; 8]);
        }
    }

    /// SYNC with the length that 1019h asks for: synchronous PDOs are received and sent.
    fn on_sync(&mut self, now: Timestamp, data: &[u8]) {
        if !self.phase.is_running() || !self.objects.consumes_sync() {
            return;
        }
        let fits = self.sync.has_length(data.len());
        self.report(now, Condition::SyncLength, !fits);
        if fits {
            self.beat(now, data.first().copied());
        }
    }

    /// SYNC was received or sent.
    fn beat(&mut self, now: Timestamp, counter: Option<u8>) {
        self.sync.open(now);
        for position in 0..self.rpdos.len() {
            let held = self.rpdos.get_mut(position).and_then(|rpdo| rpdo.on_sync());
            held.into_iter().for_each(|payload| self.apply(now, position, payload));
        }
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.on_sync(now, counter, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    fn on_rpdo(&mut self, now: Timestamp, position: u16, data: &[u8]) {
        if !self.phase.receives_pdos(&self.firmware) {
            return;
        }
        let position = usize::from(position);
        let Some(rpdo) = self.rpdos.get_mut(position) else { return };
        let (ordinal, len) = (rpdo.ordinal(), rpdo.len());
        let too_long = data.len() > len;
        if rpdo.is_synchronous() && self.sync.is_closed() || too_long && !self.firmware.takes_long_rpdo() {
            return;
        }
        let received = rpdo.on_frame(now, data);
        let too_short = received == Received::TooShort;
        self.report(now, Condition::RpdoTooShort { rpdo: ordinal }, too_short);
        self.report(now, Condition::RpdoTooLong { rpdo: ordinal }, too_long);
        if !too_short {
            self.report(now, Condition::RpdoLate { rpdo: ordinal }, false);
        }
        if let Received::Act(payload) = received {
            self.apply(now, position, payload);
        }
    }

    /// The values of an RPDO act.
    fn apply(&mut self, now: Timestamp, position: usize, payload: Payload) {
        let Some(rpdo) = self.rpdos.get(position) else { return };
        for (at, value) in rpdo.values(payload) {
            self.objects.receive(now, at, value);
        }
        self.act_on_writes(now);
    }

    fn on_time(&mut self, now: Timestamp, frame: &Frame) {
        if self.phase.is_running()
            && frame.len() == 6
            && let Ok(time) = TimeOfDay::read(frame.data())
        {
            self.objects.clock.set(now, time);
            self.after_change(now);
        }
    }

    fn on_peer_emcy(&mut self, frame: &Frame) {
        if frame.len() == 8 && self.phase.is_running() {
            self.objects.received_emcy = u64::from_le_bytes(frame.bytes());
        }
    }

    /// An error control message of another node.
    fn on_peer(&mut self, now: Timestamp, node: u8) {
        if self.phase.is_running() && self.consumer.on_heartbeat(now, node, &self.firmware) {
            self.report(now, Condition::Heartbeat { node }, false);
        }
    }

    /// Puts into the outbox what has become ready: after every event, so that nothing stays due. Finds out when the
    /// next event is.
    pub(super) fn settle(&mut self, now: Timestamp) {
        while let Some(frame) = self.poll_emcy(now) {
            push(&mut self.outbox, frame);
        }
        self.send_answers(now);
        self.beside_sdo = Timestamp::ZERO;
        self.wake = match self.phase {
            Phase::Unconfigured => self.activation_timeout(),
            // What services still waited for at the reset is settled when they start again.
            Phase::Initialising { until } => {
                until.min(self.activation_timeout()).min(self.emcy_timeout()).min(self.next_of_sdo())
            }
            _ if self.silent_until > Timestamp::ZERO => self.silent_until,
            _ => {
                self.beside_sdo = self.next_beside_sdo();
                self.beside_sdo.min(self.next_of_sdo())
            }
        };
    }

    /// As [`Device::settle`], after something that concerned the SDO servers alone.
    fn settle_sdo(&mut self, now: Timestamp) {
        if self.beside_sdo == Timestamp::ZERO {
            return self.settle(now);
        }
        self.send_answers(now);
        self.wake = self.beside_sdo.min(self.next_of_sdo());
    }

    fn send_answers(&mut self, now: Timestamp) {
        let Some(node) = self.node else { return };
        while let Some(frame) = self.sdo.poll(now, node) {
            push(&mut self.outbox, frame);
        }
        for channel in &mut self.second_sdos {
            while let Some(frame) = channel.poll(now, node) {
                push(&mut self.outbox, frame);
            }
        }
    }

    fn next_of_sdo(&self) -> Timestamp {
        self.second_sdos.iter().fold(self.sdo.timeout(), |next, channel| next.min(channel.timeout()))
    }

    fn activation_timeout(&self) -> Timestamp {
        self.activation.as_ref().map_or(Timestamp::MAX, |activation| activation.timeout())
    }

    /// The next event of all services but SDO, while they work.
    fn next_beside_sdo(&self) -> Timestamp {
        let services = [
            self.activation_timeout(),
            self.heartbeat.timeout(),
            self.consumer.timeout(),
            self.guarding.timeout(),
            self.store.timeout(),
            self.emcy_timeout(),
            self.shaft_due,
            self.sync.timeout(),
            self.objects.clock.timeout(),
        ];
        let next = services.into_iter().fold(Timestamp::MAX, Timestamp::min);
        let next = self.tpdos.iter().fold(next, |next, tpdo| next.min(tpdo.timeout()));
        self.rpdos.iter().fold(next, |next, rpdo| next.min(rpdo.timeout()))
    }

    /// The producers of this device whose time has come.
    fn produce(&mut self, now: Timestamp) {
        if let Some(heartbeat) = self.heartbeat.poll(now, self.phase, &self.firmware) {
            self.send_error_control(heartbeat);
        }
        if let Some(time) = self.objects.clock.poll(now) {
            push(&mut self.outbox, time.to_frame(self.objects.clock.own_can_id()));
        }
        if let Some(sync) = self.sync.poll(now) {
            push(&mut self.outbox, sync.to_frame(self.sync.own_can_id()));
            let SyncMessage { counter } = sync;
            self.beat(now, counter);
        }
        if now >= self.shaft_due {
            self.find_errors(now);
            self.watch_shaft(now);
        }
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.poll(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    /// Transfers whose client says nothing any more end.
    fn expire_sdo(&mut self, now: Timestamp) {
        self.sdo.expire(now, &self.objects);
        self.second_sdos.iter_mut().for_each(|channel| channel.expire(now, &self.objects));
    }

    /// What is awaited of others and did not come.
    fn miss(&mut self, now: Timestamp) {
        while let Some(node) = self.consumer.poll(now) {
            self.report(now, Condition::Heartbeat { node }, true);
        }
        if self.guarding.is_lost(now) {
            self.on_master_lost(now);
        }
        for position in 0..self.rpdos.len() {
            if let Some(rpdo) = self.rpdos.get_mut(position)
                && rpdo.is_late(now)
            {
                let rpdo = rpdo.ordinal();
                self.report(now, Condition::RpdoLate { rpdo }, true);
            }
        }
        if self.sync.close(now) {
            self.rpdos.iter_mut().for_each(|rpdo| rpdo.forget());
            let tpdos = &self.tpdos;
            let late = |frame: &Frame| {
                let can_id = frame.id().as_standard();
                can_id.is_some_and(|id| tpdos.iter().any(|tpdo| tpdo.is_synchronous() && tpdo.uses(id)))
            };
            self.outbox.retain(|frame| !late(frame));
        }
    }

    /// Which service a frame of the device itself belongs to.
    pub(super) fn service_of(&self, frame: &Frame) -> Option<Service> {
        let (can_id, node) = (frame.id().as_standard()?, u16::from(self.node?.raw()));
        Some(match can_id {
            _ if self.tpdos.iter().any(|tpdo| tpdo.uses(can_id)) => Service::Pdo,
            lss::SLAVE_CAN_ID => Service::Lss,
            id if id == error_control::CAN_ID_BASE + node => Service::ErrorControl,
            id if id == sdo::RESPONSE_BASE + node => Service::Sdo,
            id if self.second_sdos.iter().any(|channel| channel.responds_with(id)) => Service::Sdo,
            id if id == self.sync.own_can_id() || id == self.objects.clock.own_can_id() => Service::Broadcast,
            _ => Service::Emcy,
        })
    }

    /// Whether a synchronous PDO that has not begun is too late.
    fn is_too_late(&self, pending: &Frame) -> bool {
        let can_id = pending.id().as_standard();
        self.sync.is_closed()
            && can_id.is_some_and(|id| self.tpdos.iter().any(|tpdo| tpdo.is_synchronous() && tpdo.uses(id)))
    }

    /// A frame as the services get it.
    fn receive(&mut self, now: Timestamp, frame: &Frame) {
        let standard = frame.id().as_standard();
        let Some(can_id) = standard.or_else(|| self.confuses_formats().then(|| frame.id().raw() as u16 & 0x7FF)) else {
            return;
        };
        if self.hangs || now < self.silent_until {
            return;
        }
        if frame.is_remote() {
            if let Some(node) = self.node {
                self.on_remote(now, can_id, node);
                self.settle(now);
            }
            return;
        }
        let route = self.routes.of(can_id);
        if route == Route::Others || frame.is_error() || frame.is_fd() || frame.is_xl() {
            return;
        }
        if self.overload.on_frame(now, &self.firmware) {
            self.restart(now);
        } else if route == Route::Sdo && is_plain_upload(frame) {
            self.on_sdo(now, frame);
            return self.settle_sdo(now);
        } else {
            self.on_data(now, route, can_id, frame);
        }
        self.settle(now);
    }
}

/// Whether a request does nothing but read: initiate upload or upload segment, and not the error register, reading which
/// may acknowledge an error.
fn is_plain_upload(frame: &Frame) -> bool {
    let [command, low, high, ..] = frame.bytes();
    matches!(command >> 5, 2 | 3) && u16::from_le_bytes([low, high]) != ERROR_REGISTER.index.0
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
        match self.mischief.on_receive(frame, self.node, self.lss_address()) {
            Incoming::Frames(first, second) => {
                self.receive(now, &first);
                second.iter().for_each(|second| self.receive(now, second));
            }
            Incoming::Lost => {}
            Incoming::Answered(answer) => push(&mut self.outbox, answer),
        }
    }

    fn poll_transmit(&mut self, _: Timestamp) -> Option<Frame> {
        if self.activation.is_some() {
            return None;
        }
        if !self.mischief.is_active() {
            return self.outbox.pop_front();
        }
        loop {
            let frame = self.outbox.pop_front()?;
            if let Some(frame) = self.mischief.on_send(frame, self.node) {
                return Some(frame);
            }
        }
    }

    fn poll_timeout(&self) -> Option<Timestamp> {
        (self.wake < Timestamp::MAX && !self.hangs).then_some(self.wake)
    }

    fn handle_timeout(&mut self, now: Timestamp) {
        if now < self.beside_sdo {
            self.expire_sdo(now);
            return self.settle_sdo(now);
        }
        self.go_on_with_activation(now);
        match self.phase {
            Phase::Initialising { until } if now >= until => self.boot_up(now),
            Phase::Initialising { .. } => self.expire_sdo(now),
            Phase::Unconfigured => {}
            _ if now < self.silent_until => {}
            _ => {
                if self.silent_until > Timestamp::ZERO {
                    self.end_silence(now);
                }
                if let Some(node) = self.node {
                    self.store.finish(now, &self.objects.parameters, self.objects.encoder.as_ref(), node);
                }
                self.expire_sdo(now);
                self.produce(now);
                self.miss(now);
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
            || self.service_of(pending).is_some_and(|service| !self.phase.serves(service, &self.firmware))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Faults;
    use crate::models::Model;
    use canvass_traces::{CanId, Duration};

    /// A heartbeat that is awaited when a reset comes is not waited for during initialisation: what is due then can't be
    /// served, and the device would be woken without end.
    #[test]
    fn nothing_wakes_a_device_that_initialises() {
        let model = Model::by_id("reference-301").unwrap();
        let mut device = Device::new(model, NodeId::new(10), Faults::NONE, 0);
        let frame = |id, data: &[u8]| Frame::new(CanId::standard_masked(id), data).unwrap();
        let booted = device.poll_timeout().unwrap();
        device.handle_timeout(booted);
        // Node 11 is awaited every 50 ms, and heard once.
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
