//! What a written object changes, and what an error does.

use super::emcy::Condition;
use super::nmt::{Phase, Service};
use super::objects::Objects;
use super::store::StoreCommand;
use super::{Device, PLACEHOLDER, push};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::{emcy as emcy_wire, error_control};
use canvass_analyzer::{CobId, Multiplexer};
use canvass_traces::{Duration, Frame, Timestamp};

/// The temperature of the sensor as 2120h counts it: degrees Celsius plus 64.
pub(super) const TEMPERATURE: u8 = 0x56;

/// How often the speed of a shaft that turns is compared with its limit.
const SHAFT_WATCH: Duration = Duration::from_millis(100);

const OPERATING_PARAMETERS: Multiplexer = Multiplexer::new(0x6000, 0);

/// Bit 2 of 6000h.
const SCALING: u64 = 1 << 2;

impl Device {
    /// Acts on everything that was written since.
    pub(super) fn act_on_writes(&mut self, now: Timestamp) {
        let mut any = false;
        while let Some((at, value)) = self.objects.written.pop() {
            self.act_on(now, at, value);
            any = true;
        }
        if any {
            self.after_change(now);
        }
    }

    /// What a written object changes.
    fn act_on(&mut self, now: Timestamp, at: Multiplexer, value: u64) {
        let storage = &self.objects.model.sheet().storage;
        if let Some(command) = StoreCommand::of(at, storage) {
            if matches!(command, StoreCommand::Restore(_)) && self.firmware.restores_at_once() {
                self.objects.parameters.restore(self.node.unwrap_or(PLACEHOLDER));
            }
            self.begin_store(now, command);
        }
        self.persist_at_once(now, at, value);
        self.forget_verification(at);
        match at.index.0 {
            0x1003 => self.objects.errors.clear_history(),
            0x1005..=0x1007 | 0x1019 => self.configure_sync(now),
            0x100C | 0x100D => self.configure_guarding(now),
            0x1012 => self.configure_clock(now),
            0x1013 => self.objects.clock.stamp(now, value as u32),
            0x1016 if self.heartbeat_consumer_acts(at) => {
                self.consumer.configure(now, &self.objects.parameters, &self.firmware);
            }
            0x1017 => self.heartbeat.start(now, value, &self.firmware),
            0x1200..0x1280 => self.second_sdos.iter_mut().for_each(|channel| channel.configure(&self.objects)),
            0x1400..0x1800 => self.configure_rpdos(),
            0x1800..0x1C00 => self.configure_tpdos(now),
            // The cyclic timer of CiA 406; in other profiles these are outputs.
            0x6200 if self.objects.encoder.is_some() => self.configure_tpdos(now),
            _ => {}
        }
        if let 0x1005 | 0x1012 | 0x1014 | 0x1028 | 0x1200..0x1280 | 0x1400..0x1C00 = at.index.0 {
            self.find_routes();
        }
    }

    fn begin_store(&mut self, now: Timestamp, command: StoreCommand) {
        let sheet = self.objects.model.sheet();
        let done = now + sheet.timing.store();
        if command.is_save() {
            if sheet.quirks.silent_while_storing {
                self.silent_until = done;
            }
            self.objects.take_waiting();
        }
        self.store.begin(done, command, &self.firmware);
    }

    /// Some objects are stored as soon as they are written.
    fn persist_at_once(&mut self, now: Timestamp, at: Multiplexer, value: u64) {
        let model = self.objects.model.clone();
        let sheet = model.sheet();
        if at == OPERATING_PARAMETERS && sheet.quirks.scaling_bit_guards && value & SCALING == 0 {
            self.objects.reset_scaling(self.node.unwrap_or(PLACEHOLDER));
            for index in [0x6001, 0x6002] {
                self.store.forget_number(Multiplexer::new(index, 0), &self.objects.parameters);
            }
            self.configure_tpdos(now);
        }
        if sheet.storage.persist_at_once.contains(&at) {
            self.store.save_number(at, value, &self.objects.parameters);
            if let Some(encoder) = &self.objects.encoder {
                self.store.save_offset(encoder.offset());
            }
        }
    }

    /// The end of a silence: what had become due meanwhile is not made up for.
    pub(super) fn end_silence(&mut self, now: Timestamp) {
        self.silent_until = Timestamp::ZERO;
        self.start_heartbeat(now);
        self.configure_guarding(now);
        self.configure_tpdos(now);
    }

    /// 1020h: date and time of the configuration are gone as soon as it is changed.
    fn forget_verification(&mut self, at: Multiplexer) {
        let is_command = StoreCommand::of(at, &self.objects.model.sheet().storage).is_some();
        let kept = self.firmware.keeps_configuration_date();
        if !matches!(at.index.0, 0x1003 | 0x1020) && !is_command && !kept {
            self.objects.parameters.set_number(0x1020, 1, 0);
            self.objects.parameters.set_number(0x1020, 2, 0);
        }
    }

    fn heartbeat_consumer_acts(&self, at: Multiplexer) -> bool {
        let needs_store = self.objects.model.sheet().network.heartbeat_consumer_needs_store;
        !needs_store || self.store.number(at, &self.objects.parameters).is_some()
    }

    /// Values have changed: errors may have come or gone, PDOs may have to be sent.
    pub(super) fn after_change(&mut self, now: Timestamp) {
        self.find_errors(now);
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.on_change(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    pub(super) fn find_errors(&mut self, now: Timestamp) {
        let Objects { parameters, encoder, .. } = &self.objects;
        let limits = parameters.number(0x2120, 2).zip(parameters.number(0x2120, 3));
        let shaft = encoder.as_ref().map(|it| (it.is_overspeed(now, parameters), it.has_position_error()));
        if let Some((low, high)) = limits.map(|(low, high)| (low as u8, high as u8)) {
            let outside = !(low..=high).contains(&TEMPERATURE) && self.firmware.reports_temperature();
            self.report(now, Condition::Temperature { now: TEMPERATURE, low, high }, outside);
        }
        if let Some((too_fast, wrong_position)) = shaft {
            self.report(now, Condition::Overspeed, too_fast);
            self.report(now, Condition::Position, wrong_position);
        }
    }

    /// A shaft that turns can become too fast, or be so no longer, without anything being written.
    pub(super) fn watch_shaft(&mut self, now: Timestamp) {
        let warns = self.objects.model.sheet().encoder.is_some_and(|encoder| encoder.speed_warning_rpm.is_some());
        let watched = warns && self.objects.is_moving() && self.phase.is_running();
        self.shaft_due = if watched { now + SHAFT_WATCH } else { Timestamp::MAX };
    }

    /// A condition is there or gone.
    pub(super) fn report(&mut self, now: Timestamp, condition: Condition, present: bool) {
        if self.objects.errors.set(condition, present) && present {
            self.react(now, condition);
        }
        if self.phase == Phase::Stopped {
            self.objects.errors.on_stopped();
        }
    }

    /// 1029h: the NMT state that follows an error. Without its first entry operational is left when the master or a
    /// watched node is missing.
    pub(super) fn react(&mut self, now: Timestamp, condition: Condition) {
        let Some(sub) = condition.behaviour().filter(|_| self.firmware.heeds_error_behaviour()) else {
            return;
        };
        if sub == 2 && self.firmware.ignores_profile_errors() {
            return;
        }
        let leaves_stopped = self.phase == Phase::Stopped && self.firmware.leaves_stopped_on_error();
        let behaviour = match self.objects.parameters.number(0x1029, sub) {
            Some(1) if sub == 2 && self.firmware.leaves_on_any_profile_error() => Some(0),
            behaviour => behaviour.or((sub == 1).then_some(0)),
        };
        match behaviour {
            Some(0) if self.phase == Phase::Operational || leaves_stopped => self.enter(now, Phase::PreOperational),
            Some(2) if self.phase.is_running() => self.enter(now, Phase::Stopped),
            _ => {}
        }
    }

    pub(super) fn start_heartbeat(&mut self, now: Timestamp) {
        let time = self.objects.parameters.number_or_zero(0x1017, 0);
        self.heartbeat.boot(now, time, &self.firmware);
    }

    pub(super) fn configure_guarding(&mut self, now: Timestamp) {
        let number = |index| self.objects.parameters.number_or_zero(index, 0);
        self.guarding.configure(now, number(0x100C), number(0x100D), &self.firmware);
    }

    pub(super) fn configure_tpdos(&mut self, now: Timestamp) {
        self.tpdos.iter_mut().for_each(|tpdo| tpdo.configure(now, &self.objects));
    }

    pub(super) fn configure_rpdos(&mut self) {
        self.rpdos.iter_mut().for_each(|rpdo| rpdo.configure(&self.objects));
    }

    pub(super) fn configure_sync(&mut self, now: Timestamp) {
        let may_send = self.phase.serves(Service::Broadcast, &self.firmware);
        let Objects { parameters, model, .. } = &self.objects;
        self.sync.configure(now, parameters, &model.sheet().network, may_send);
        // The SYNC start value of TPDOs counts only while SYNC has a counter.
        self.configure_tpdos(now);
    }

    pub(super) fn configure_clock(&mut self, now: Timestamp) {
        let may_send = self.phase.serves(Service::Broadcast, &self.firmware);
        let Objects { parameters, model, clock, .. } = &mut self.objects;
        clock.configure(now, parameters, &model.sheet().network, may_send);
    }

    pub(super) fn start_tpdos(&mut self, now: Timestamp) {
        for tpdo in &mut self.tpdos {
            if let Some(frame) = tpdo.start(now, &self.objects) {
                push(&mut self.outbox, frame);
            }
        }
    }

    pub(super) fn send_error_control(&mut self, message: error_control::ErrorControl) {
        if let Some(node) = self.node {
            push(&mut self.outbox, message.to_frame(error_control::CAN_ID_BASE + u16::from(node.raw())));
        }
    }

    /// The next EMCY, if there is one and it may be sent.
    pub(super) fn poll_emcy(&mut self, now: Timestamp) -> Option<Frame> {
        if now < self.emcy_timeout() {
            return None;
        }
        let inhibit = Duration::from_micros(100 * self.objects.parameters.number_or_zero(0x1015, 0));
        // One that 1014h silences is gone, the next one may follow at once.
        loop {
            let emcy = self.objects.errors.poll(now, inhibit)?;
            let cob_id = self.emcy_cob_id()?;
            if cob_id.is_valid() || self.firmware.sends_emcy_when_invalid() {
                return Some(emcy.to_frame(cob_id.can_id() as u16));
            }
        }
    }

    fn emcy_cob_id(&self) -> Option<CobId> {
        let usual = CobId(u32::from(emcy_wire::CAN_ID_BASE) + u32::from(self.node?.raw()));
        Some(self.objects.parameters.number(0x1014, 0).map_or(usual, |raw| CobId(raw as u32)))
    }

    pub(super) fn emcy_timeout(&self) -> Timestamp {
        match self.phase.serves(Service::Emcy, &self.firmware) {
            true => self.objects.errors.timeout(),
            false => Timestamp::MAX,
        }
    }
}
