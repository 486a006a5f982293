//! The object dictionary as an SDO client meets it: access rights, lengths, limits, and the objects with behaviour.

use super::PLACEHOLDER;
use super::clock::Clock;
use super::emcy::Errors;
use super::encoder::Encoder;
use super::lss_slave::UNCONFIGURED;
use super::motion::Motion;
use super::parameters::{Content, Parameters, Reading};
use super::store::StoreCommand;
use crate::models::Model;
use crate::{Fault, Faults};
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{Multiplexer, NodeId};
use canvass_traces::Timestamp;

/// The values, and what stands behind them.
#[derive(Clone, Debug)]
pub(super) struct Objects {
    pub model: Model,
    pub parameters: Parameters,
    pub errors: Errors,
    pub encoder: Option<Encoder>,
    pub clock: Clock,
    /// The bytes of the last EMCY of a node of 1028h.
    pub received_emcy: u64,
    pub faults: Faults,
    /// What was written by SDO and not yet acted on.
    pub written: Vec<(Multiplexer, u64)>,
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
            clock: Clock::new(Timestamp::ZERO, faults),
            received_emcy: 0,
            faults,
            written: Vec::with_capacity(4),
        }
    }

    /// Whether measured values change by themselves.
    pub fn is_moving(&self) -> bool {
        self.encoder.as_ref().is_some_and(|encoder| !encoder.motion().is_still())
    }

    /// The number that an object has now, as a PDO carries it; `None` for a string or no object.
    pub fn number(&self, now: Timestamp, at: Multiplexer) -> Option<u64> {
        match self.live(now, at) {
            Ok(Some(number)) => Some(number),
            _ => self.parameters.number(at.index.0, at.sub.0),
        }
    }

    /// The value of an object that is not simply what was written last.
    fn live(&self, now: Timestamp, at: Multiplexer) -> Result<Option<u64>, AbortCode> {
        let network = &self.model.sheet().network;
        Ok(match at.index.0 {
            0x1001 => Some(u64::from(self.errors.register())),
            0x1003 => Some(self.errors.history(at.sub.0)?),
            0x1013 if network.time_consumer => Some(u64::from(self.clock.micros(now))),
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

    fn measured(&self, now: Timestamp, at: Multiplexer) -> Option<u64> {
        self.encoder.as_ref().and_then(|encoder| encoder.value(now, at, &self.parameters))
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
        self.put(now, at, value);
        Ok(())
    }

    /// An RPDO carries a value for an object. What the object does not take is left out; nobody is told.
    pub fn receive(&mut self, now: Timestamp, at: Multiplexer, value: u64) {
        if self.faults.has(Fault::RpdoRangeUnchecked) || self.check(at, value).is_ok() {
            self.put(now, at, value);
        }
    }

    /// Writes a number that was checked.
    fn put(&mut self, now: Timestamp, at: Multiplexer, value: u64) {
        if !self.is_command(at) {
            self.parameters.set(at, Content::Number(value));
            self.write_through(at, value);
        }
        if at == Multiplexer::new(0x6003, 0)
            && let Some(encoder) = &mut self.encoder
        {
            encoder.preset(now, value, &self.parameters);
        }
        self.written.push((at, value));
    }

    fn check_length(&self, at: Multiplexer, len: usize) -> Result<(), AbortCode> {
        match self.parameters.entry(at)?.check_length(len) {
            Err(AbortCode::LENGTH_TOO_HIGH) if self.faults.has(Fault::SdoLengthUnchecked) => Ok(()),
            Err(AbortCode::LENGTH_TOO_LOW) if self.faults.has(Fault::SdoShortLengthUnchecked) => Ok(()),
            checked => checked,
        }
    }

    /// Whether a write to the object does something instead of leaving a value.
    fn is_command(&self, at: Multiplexer) -> bool {
        at == Multiplexer::new(0x1003, 0) || StoreCommand::of(at, &self.model.sheet().storage).is_some()
    }

    /// Whether writing the object takes as long as writing the non-volatile memory.
    pub fn takes_long(&self, at: Multiplexer) -> bool {
        StoreCommand::of(at, &self.model.sheet().storage).is_some()
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
