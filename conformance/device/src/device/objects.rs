//! The object dictionary as seen by an SDO client: access rights, lengths, limits, and objects with behaviour.

use super::PLACEHOLDER;
use super::application::{self, Application, Surroundings};
use super::clock::Clock;
use super::condition::Condition;
use super::errors::Errors;
use super::lss_slave::UNCONFIGURED;
use super::motion::Motion;
use super::overlay;
use super::parameters::{Content, Parameters, Reading};
use super::store::StoreCommand;
use crate::models::Model;
use crate::{Fault, Firmware, Liberty};
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer, NodeId};
use canvass_traces::Timestamp;

/// The values of the object dictionary, and the state from which objects with behaviour take their values.
#[derive(Clone, Debug)]
pub(super) struct Objects {
    pub model: Model,
    pub parameters: Parameters,
    pub errors: Errors,
    pub application: Option<Box<dyn Application>>,
    pub clock: Clock,
    /// The bytes of the last EMCY from a node of 1028h.
    pub received_emcy: u64,
    pub firmware: Firmware,
    /// Numbers that were written, by SDO or PDO, and that the services have not handled yet.
    pub written: Vec<(Multiplexer, u64)>,
    /// Whether the firmware hangs: no answers until a reset.
    pub wedged: bool,
    /// Numbers written to objects that take effect only when they are stored.
    waiting: Vec<(Multiplexer, u64)>,
}

impl Objects {
    /// Whether the firmware has this fault.
    pub const fn has(&self, fault: Fault) -> bool {
        self.firmware.has(fault)
    }

    /// Whether the firmware takes this liberty.
    pub const fn takes(&self, liberty: Liberty) -> bool {
        self.firmware.takes(liberty)
    }

    /// The object dictionary of a device as delivered.
    pub fn new(model: &Model, node: Option<NodeId>, motion: &Motion, firmware: &Firmware) -> Self {
        let mut parameters = Parameters::new(model, node.unwrap_or(PLACEHOLDER));
        if let Some(at) = model.sheet().network.node_id_object {
            let node_id = node.map_or(UNCONFIGURED, NodeId::raw);
            parameters.redefine(at, Content::Number(u64::from(node_id)));
        }
        overlay::plant(&mut parameters, firmware);
        let history = parameters.entries().filter(|entry| entry.at.index.0 == object::PREDEFINED_ERROR_FIELD).count();
        Self {
            model: model.clone(),
            parameters,
            errors: Errors::new(history.saturating_sub(1), &model.sheet().quirks, firmware),
            application: application::of(model, motion, firmware),
            clock: Clock::new(Timestamp::ZERO, firmware),
            received_emcy: 0,
            firmware: *firmware,
            written: Vec::with_capacity(4),
            wedged: false,
            waiting: Vec::new(),
        }
    }

    /// Whether measured values change by themselves.
    pub(crate) fn is_moving(&self) -> bool {
        self.application.as_ref().is_some_and(|application| application.is_moving())
    }

    /// The parts of the device that the application may use.
    pub fn surroundings(&self) -> Surroundings<'_> {
        Surroundings { parameters: &self.parameters, errors: &self.errors }
    }

    /// The current number of an object for a PDO; `None` for a string or an absent object. `again` is set if the object
    /// occurs in the PDO a second time.
    pub fn number(&self, now: Timestamp, at: Multiplexer, again: bool) -> Option<u64> {
        let application = self.application.as_ref().filter(|_| at.index.0 >= 0x2000);
        application
            .and_then(|application| application.process_value(now, at, again, &self.surroundings()))
            .or_else(|| self.live(now, at).ok().flatten())
            .or_else(|| self.parameters.number(at.index.0, at.sub.0))
    }

    /// The value of an object that the device computes; `None` if the object holds its last written value.
    fn live(&self, now: Timestamp, at: Multiplexer) -> Result<Option<u64>, AbortCode> {
        let network = &self.model.sheet().network;
        Ok(match at.index.0 {
            object::ERROR_REGISTER => Some(u64::from(self.errors.register())),
            object::PREDEFINED_ERROR_FIELD => Some(self.errors.history(at.sub.0)?),
            object::HIGH_RESOLUTION_TIME_STAMP if network.time_consumer => Some(u64::from(self.clock.micros(now))),
            ..0x2000 => None,
            _ if network.clock_object == Some(at) => {
                let time = self.clock.time(now);
                Some(u64::from(time.days) << 32 | u64::from(time.raw_milliseconds))
            }
            _ if network.received_emcy_object == Some(at) => Some(self.received_emcy),
            _ => self.measured(now, at).or_else(|| {
                let source = self.followed(at)?;
                self.measured(now, source).or_else(|| self.parameters.number(source.index.0, source.sub.0))
            }),
        })
    }

    /// The live value of an object of the profile, in the form of this model.
    fn measured(&self, now: Timestamp, at: Multiplexer) -> Option<u64> {
        if let Some((_, waiting)) = self.waiting.iter().find(|(object, _)| *object == at) {
            return Some(*waiting);
        }
        self.application.as_ref()?.value(now, at, &self.surroundings())
    }

    /// The value for an SDO upload.
    ///
    /// # Errors
    /// The abort code if the object can't be read.
    pub fn upload(&self, now: Timestamp, at: Multiplexer) -> Result<Reading<'_>, AbortCode> {
        let entry = self.parameters.entry(at).map_err(|code| self.firmware.missing_code(code))?;
        if !entry.readable {
            return Err(self.own(AbortCode::WRITE_ONLY));
        }
        Ok(entry.reading(self.live(now, at)?))
    }

    /// This model's abort code for the reason of the standard code `code`.
    fn own(&self, code: AbortCode) -> AbortCode {
        self.model.sheet().quirks.abort_code(code)
    }

    /// Checks whether an SDO download to an object may begin; `len` is the number of bytes, if it is known. Returns the
    /// largest number of bytes that the object accepts.
    ///
    /// # Errors
    /// The abort code if the object can't be written.
    pub fn begin_download(&self, at: Multiplexer, len: Option<usize>) -> Result<usize, AbortCode> {
        let entry = self.parameters.entry(at).map_err(|code| self.firmware.missing_code(code))?;
        if !entry.writable {
            return if self.firmware.has(Fault::SdoReadOnlyWritable) {
                Ok(entry.longest())
            } else {
                Err(self.own(self.firmware.read_only_code()))
            };
        }
        if let Some(len) = len {
            self.check_length(at, len)?;
        }
        Ok(entry.longest())
    }

    /// The length of the object's values in bytes; `None` if it is not fixed.
    pub fn size(&self, at: Multiplexer) -> Option<usize> {
        self.parameters.entry(at).ok()?.size()
    }

    /// Writes an object by SDO.
    ///
    /// # Errors
    /// The abort code if the object can't be written, or does not accept this value. The object then keeps the old
    /// value.
    pub fn download(&mut self, now: Timestamp, at: Multiplexer, bytes: &[u8]) -> Result<(), AbortCode> {
        self.begin_download(at, Some(bytes.len()))?;
        let entry = self.parameters.entry(at)?;
        if !entry.writable {
            return Ok(());
        }
        let content = entry.decode(bytes);
        let Content::Number(value) = content else {
            self.parameters.set(at, content);
            return Ok(());
        };
        self.check(at, value).map_err(|code| self.own(code))?;
        if StoreCommand::of(at, &self.model.sheet().storage).is_some_and(StoreCommand::is_save) {
            self.check_waiting()?;
        }
        self.put(now, at, value);
        Ok(())
    }

    /// Handles the value of an RPDO for an object. The device ignores a value that the object does not accept, without
    /// a report.
    pub fn receive(&mut self, now: Timestamp, at: Multiplexer, value: u64) {
        if self.firmware.has(Fault::RpdoRangeUnchecked) || self.check(at, value).is_ok() {
            self.put(now, at, value);
        }
    }

    /// Writes a checked number.
    fn put(&mut self, now: Timestamp, at: Multiplexer, value: u64) {
        if self.model.sheet().quirks.acts_when_stored.contains(&at) {
            self.waiting.retain(|(object, _)| *object != at);
            self.waiting.push((at, value));
        } else if !self.is_command(at) {
            self.parameters.set(at, Content::Number(value));
            self.write_through(at, value);
        }
        let surroundings = Surroundings { parameters: &self.parameters, errors: &self.errors };
        if let Some(application) = &mut self.application {
            self.wedged = application.wedges(at, value);
            application.on_written(now, at, value, &surroundings);
        }
        self.written.push((at, value));
    }

    /// Applies the values that waited for a store.
    pub(crate) fn take_waiting(&mut self) {
        for (at, value) in std::mem::take(&mut self.waiting) {
            self.parameters.set(at, Content::Number(value));
        }
    }

    /// Drops the values that waited for a store, at a reset.
    pub(crate) fn drop_waiting(&mut self) {
        self.waiting.clear();
    }

    /// Checks whether all waiting values are within their limits. A value outside its limits is an alarm.
    fn check_waiting(&mut self) -> Result<(), AbortCode> {
        if !self.model.sheet().quirks.limits_checked_at_store {
            return Ok(());
        }
        let fits = |&(at, value): &(Multiplexer, u64)| {
            self.parameters.entry(at).and_then(|entry| entry.check_range(value)).is_ok()
        };
        let fits = self.waiting.iter().all(fits);
        self.errors.set(Condition::Parameter, !fits);
        if fits { Ok(()) } else { Err(self.own(AbortCode::HARDWARE)) }
    }

    /// Resets these objects to their defaults.
    pub fn reset(&mut self, indexes: &[u16], node: NodeId) {
        self.waiting.retain(|(at, _)| !indexes.contains(&at.index.0));
        for (entry, content) in self.parameters.entries_mut() {
            if indexes.contains(&entry.at.index.0) {
                *content = entry.default_content(node);
            }
        }
    }

    /// The objects that a write of this value resets to their defaults.
    pub fn resets(&self, at: Multiplexer, value: u64) -> &'static [u16] {
        self.application.as_ref().map_or(&[], |application| application.resets(at, value))
    }

    fn check_length(&self, at: Multiplexer, len: usize) -> Result<(), AbortCode> {
        match self.parameters.entry(at)?.check_length(len) {
            Err(AbortCode::LENGTH_TOO_HIGH) if self.firmware.has(Fault::SdoLengthUnchecked) => Ok(()),
            Err(AbortCode::LENGTH_TOO_LOW) if self.firmware.has(Fault::SdoShortLengthUnchecked) => Ok(()),
            Err(code) => Err(self.model.sheet().network.sdo_length_abort.map_or(code, AbortCode)),
            Ok(()) => self.check_usual_length(at, len),
        }
    }

    /// Checks the length in a firmware that keeps strings in fixed arrays: a string must keep its current length.
    fn check_usual_length(&self, at: Multiplexer, len: usize) -> Result<(), AbortCode> {
        let entry = self.parameters.entry(at)?;
        if entry.size().is_some() || !self.firmware.takes(Liberty::StringsOfOneLength) {
            return Ok(());
        }
        match entry.reading(None).bytes().len() {
            0 => Ok(()),
            usual if len < usual => Err(AbortCode::LENGTH_TOO_LOW),
            usual if len > usual => Err(AbortCode::LENGTH_TOO_HIGH),
            _ => Ok(()),
        }
    }

    /// Bit 31, if it is set in the delivered COB-ID. In 1005h of DS-301 V3.0 this bit means that the device consumes
    /// SYNC.
    fn consumer_bit(&self, at: Multiplexer) -> u64 {
        self.parameters.entry(at).map_or(0, |entry| entry.default_bits()) & u64::from(CobId::INVALID)
    }

    /// Whether the device consumes SYNC.
    pub(crate) fn consumes_sync(&self) -> bool {
        let needed = self.consumer_bit(Multiplexer::new(object::COB_ID_SYNC, 0));
        self.parameters.number_or_zero(object::COB_ID_SYNC, 0) & needed == needed
            || self.firmware.has(Fault::SyncConsumerBitIgnored)
    }

    /// Whether a write to the object is a command, whose value is not kept.
    fn is_command(&self, at: Multiplexer) -> bool {
        at == Multiplexer::new(object::PREDEFINED_ERROR_FIELD, 0)
            || StoreCommand::of(at, &self.model.sheet().storage).is_some()
    }

    /// Whether a write to the object takes as long as a store in the non-volatile memory.
    pub(crate) fn takes_long(&self, at: Multiplexer) -> bool {
        StoreCommand::of(at, &self.model.sheet().storage).is_some()
    }
}
