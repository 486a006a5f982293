//! The object dictionary as an SDO client meets it: access rights, lengths, limits, and the objects with behaviour.

use super::PLACEHOLDER;
use super::emcy::Errors;
use super::encoder::{self, Encoder};
use super::heartbeat_consumer;
use super::lss_slave::UNCONFIGURED;
use super::motion::Motion;
use super::parameters::{Content, Parameters, Reading};
use super::store::StoreCommand;
use super::tpdo;
use crate::models::Model;
use crate::{Fault, Faults};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer, NodeId};
use canvass_traces::Timestamp;

/// The values, and what stands behind them.
#[derive(Clone, Debug)]
pub(super) struct Objects {
    pub model: Model,
    pub parameters: Parameters,
    pub errors: Errors,
    pub encoder: Option<Encoder>,
    pub faults: Faults,
    /// What was written by SDO and not yet acted on.
    pub written: Vec<(Multiplexer, u64)>,
    /// The firmware hangs: nothing is answered until a reset.
    pub wedged: bool,
}

impl Objects {
    /// The dictionary of a device as delivered.
    pub fn new(model: &Model, node: Option<NodeId>, motion: Motion, faults: Faults) -> Self {
        let mut parameters = Parameters::new(model, node.unwrap_or(PLACEHOLDER));
        if let Some(at) = model.sheet().network.node_id_object {
            let node_id = node.map_or(UNCONFIGURED, NodeId::raw);
            parameters.redefine(at, Content::Number(u64::from(node_id)));
        }
        plant(&mut parameters, faults);
        let history = parameters.entries().iter().filter(|entry| entry.at.index.0 == 0x1003).count();
        Self {
            model: model.clone(),
            parameters,
            errors: Errors::new(history.saturating_sub(1), faults),
            encoder: Encoder::new(model, motion, faults),
            faults,
            written: Vec::with_capacity(4),
            wedged: false,
        }
    }

    /// Whether measured values change by themselves.
    pub fn is_moving(&self) -> bool {
        self.encoder.as_ref().is_some_and(|encoder| !encoder.motion().is_still())
    }

    /// The number that an object has now, as a PDO carries it; `again` where the PDO had the object before: of an encoder
    /// with redundant channels that is the other channel. `None` for a string or no object.
    pub fn number(&self, now: Timestamp, at: Multiplexer, again: bool) -> Option<u64> {
        let measured = match at.index.0 {
            0x2000.. => self.encoder.as_ref().and_then(|it| it.process_value(now, at, again, &self.parameters)),
            _ => self.live(now, at).ok().flatten(),
        };
        measured.or_else(|| self.parameters.number(at.index.0, at.sub.0))
    }

    /// The value of an object that is not simply what was written last.
    fn live(&self, now: Timestamp, at: Multiplexer) -> Result<Option<u64>, AbortCode> {
        match at.index.0 {
            0x1001 => Ok(Some(u64::from(self.errors.register()))),
            0x1003 => self.errors.history(at.sub.0).map(Some),
            0x2000.. => Ok(self.encoder.as_ref().and_then(|encoder| encoder.value(now, at, &self.parameters))),
            _ => Ok(None),
        }
    }

    /// What an SDO upload of that object gives.
    ///
    /// # Errors
    /// The abort code if it can't be read.
    pub fn upload(&self, now: Timestamp, at: Multiplexer) -> Result<Reading<'_>, AbortCode> {
        let entry = self.parameters.entry(at).map_err(|code| self.missing(code))?;
        if !entry.readable {
            return Err(AbortCode::WRITE_ONLY);
        }
        Ok(entry.reading(self.live(now, at)?))
    }

    /// Whether an SDO download to that object may begin, of so many bytes where their number is known. The largest
    /// number of bytes that the object takes.
    ///
    /// # Errors
    /// The abort code if it can't be written.
    pub fn begin_download(&self, at: Multiplexer, len: Option<usize>) -> Result<usize, AbortCode> {
        let entry = self.parameters.entry(at).map_err(|code| self.missing(code))?;
        if !entry.writable {
            return if self.faults.has(Fault::SdoReadOnlyWritable) {
                Ok(entry.longest())
            } else {
                Err(self.read_only())
            };
        }
        if let Some(len) = len {
            self.check_length(at, len)?;
        }
        Ok(entry.longest())
    }

    /// The length of values of that object, where it is fixed.
    pub fn size(&self, at: Multiplexer) -> Option<usize> {
        self.parameters.entry(at).ok()?.size()
    }

    /// Writes an object by SDO.
    ///
    /// # Errors
    /// The abort code if it can't be written, or not with this value; it then keeps the old one.
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
        self.check(at, value)?;
        if !self.is_command(at) {
            self.parameters.set(at, content);
            self.follow_links(at, value);
        }
        if let Some(encoder) = &mut self.encoder {
            self.wedged = encoder.wedges(at, value);
            encoder.on_written(now, at, value, &self.parameters);
        }
        self.written.push((at, value));
        Ok(())
    }

    fn check_length(&self, at: Multiplexer, len: usize) -> Result<(), AbortCode> {
        match self.parameters.entry(at)?.check_length(len) {
            Err(AbortCode::LENGTH_TOO_HIGH) if self.faults.has(Fault::SdoLengthUnchecked) => Ok(()),
            Err(AbortCode::LENGTH_TOO_LOW) if self.faults.has(Fault::SdoShortLengthUnchecked) => Ok(()),
            Err(code) => Err(self.model.sheet().network.sdo_length_abort.map_or(code, AbortCode)),
            Ok(()) => Ok(()),
        }
    }

    /// Whether the object takes that number now: limits, and the conditions of its service.
    fn check(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        let (parameters, faults) = (&self.parameters, self.faults);
        let sheet = self.model.sheet();
        if let Some(command) = StoreCommand::of(at, &sheet.storage) {
            return if faults.has(Fault::StoreSignatureUnchecked) {
                Ok(())
            } else {
                command.check(value, &sheet.storage)
            };
        }
        // The number of mapped objects has abort codes of its own.
        if let 0x1A00..0x1C00 = at.index.0 {
            return tpdo::check_mapping(at, value, parameters, faults);
        }
        if self.encoder.as_ref().is_some_and(|encoder| encoder.wedges(at, value)) {
            return Ok(());
        }
        self.check_bus_object(at, value)?;
        if !faults.has(Fault::SdoRangeUnchecked) {
            parameters.entry(at)?.check_range(value)?;
        }
        match at.index.0 {
            0x1003 if value != 0 => Err(AbortCode::INVALID_VALUE),
            0x1005 | 0x1012 | 0x1014 => self.check_cob_id(at, value),
            0x1016 if at.sub.0 > 0 => heartbeat_consumer::check(at, value, parameters, faults),
            0x1800..0x1A00 => tpdo::check_communication(at, value, parameters, &sheet.network, faults),
            0x6000.. => self.encoder.as_ref().map_or(Ok(()), |encoder| encoder.check(at, value, parameters)),
            _ => Ok(()),
        }
    }

    /// Node-ID and bit rate: one that exists, or "not configured" where the device is delivered so.
    fn check_bus_object(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        let sheet = self.model.sheet();
        let of_device = sheet.network.default_node_id.is_none() && value == u64::from(UNCONFIGURED);
        let exists = match Some(at) {
            object if object == sheet.network.node_id_object => !(128..=255).contains(&value),
            object if object == sheet.network.bit_rate_object => {
                value > 8 || sheet.bit_rates.iter().any(|rate| rate.object_code.map(u64::from) == Some(value))
            }
            _ => true,
        };
        if exists || of_device || self.faults.has(Fault::SdoRangeUnchecked) {
            Ok(())
        } else {
            Err(AbortCode::INVALID_VALUE)
        }
    }

    /// SYNC, TIME and EMCY: 11 bits, not restricted; the device only consumes SYNC and TIME (bit 30).
    fn check_cob_id(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        let new = CobId(value as u32);
        let reserved = new.0 & 0x1FFF_F800 != 0 || new.is_extended();
        let produces = at.index.0 != 0x1014 && new.0 & CobId::NO_RTR != 0;
        let restricted = new.is_restricted() && !self.faults.has(Fault::RestrictedCanIdAccepted);
        if reserved || produces || restricted { Err(AbortCode::INVALID_VALUE) } else { Ok(()) }
    }

    /// Whether a write to the object does something instead of leaving a value.
    fn is_command(&self, at: Multiplexer) -> bool {
        at == Multiplexer::new(0x1003, 0) || StoreCommand::of(at, &self.model.sheet().storage).is_some()
    }

    /// Whether writing the object takes as long as writing the non-volatile memory.
    pub fn takes_long(&self, at: Multiplexer) -> bool {
        StoreCommand::of(at, &self.model.sheet().storage).is_some()
    }

    /// 6200h is the event timer of the first TPDO (CiA 406).
    fn follow_links(&mut self, at: Multiplexer, value: u64) {
        match (at.index.0, at.sub.0) {
            (0x6200, 0) if self.faults.has(Fault::CyclicTimerNotLinked) => {}
            (0x6200, 0) if value == 0 && self.faults.has(Fault::CyclicTimerNotStopped) => {}
            (0x6200, 0) => self.parameters.set_number(0x1800, 5, value),
            (0x1800, 5) if self.faults.has(Fault::EventTimerNotInCyclicTimer) => {}
            (0x1800, 5) => self.parameters.set_number(0x6200, 0, value),
            _ => {}
        }
    }

    fn missing(&self, code: AbortCode) -> AbortCode {
        match code {
            AbortCode::NO_OBJECT if self.faults.has(Fault::SdoWrongCodeForNoObject) => AbortCode::NO_SUB_INDEX,
            AbortCode::NO_SUB_INDEX if self.faults.has(Fault::SdoWrongCodeForNoSubIndex) => AbortCode::NO_OBJECT,
            code => code,
        }
    }

    fn read_only(&self) -> AbortCode {
        match self.faults.has(Fault::SdoReadOnlyWrongCode) {
            true => AbortCode::DEVICE_STATE,
            false => AbortCode::READ_ONLY,
        }
    }
}

/// Faults in what the dictionary holds, not in what the firmware does.
fn plant(parameters: &mut Parameters, faults: Faults) {
    encoder::plant(parameters, faults);
    let vendor_id = Multiplexer::new(0x1018, 1);
    let device_type = Multiplexer::new(0x1000, 0);
    if faults.has(Fault::VendorIdZero) {
        parameters.redefine(vendor_id, Content::Number(0));
    }
    if faults.has(Fault::DeviceTypeProfileWrong) {
        let other = parameters.number_or_zero(0x1000, 0) & 0xFFFF_0000 | 401;
        parameters.redefine(device_type, Content::Number(other));
    }
    if faults.has(Fault::IdentityRevisionMissing) {
        parameters.remove(0x1018, Some(3));
    }
    if faults.has(Fault::ErrorRegisterMissing) {
        parameters.remove(0x1001, None);
    }
    if faults.has(Fault::DeviceNameWithGarbage) {
        let name = Multiplexer::new(0x1008, 0);
        let mut bytes = parameters.entry(name).map_or(Vec::new(), |entry| entry.reading(None).bytes().to_vec());
        bytes.extend([0x00, 0xFF, 0x1B]);
        parameters.redefine(name, Content::Bytes(bytes));
    }
}
