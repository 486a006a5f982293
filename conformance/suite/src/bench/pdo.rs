//! PDO parameters: reading them, changing them in the order that CiA 301 prescribes, and the objects that a PDO can
//! carry.

use super::Bench;
use super::sdo::number;
use crate::verdict::{Judged, Precondition, Reason, Stop};
use canvass_analyzer::dictionary::Value;
use canvass_analyzer::object;
use canvass_analyzer::wire::sync;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::observation::Subject;
use canvass_traces::{Duration, Record};

/// A PDO, given by the indexes of its parameters.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Pdo {
    /// Index of the communication parameter: from 1400h, or from 1800h.
    pub communication: u16,
    /// Index of the mapping parameter: from 1600h, or from 1A00h.
    pub mapping: u16,
}

/// The first RPDO.
pub const RPDO: Pdo =
    Pdo { communication: object::RPDO_COMMUNICATION_PARAMETER, mapping: object::RPDO_MAPPING_PARAMETER };
/// The first TPDO.
pub const TPDO: Pdo =
    Pdo { communication: object::TPDO_COMMUNICATION_PARAMETER, mapping: object::TPDO_MAPPING_PARAMETER };

/// An object that a PDO carries.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Mapped {
    /// The object. An index below 20h is a dummy entry.
    pub at: Multiplexer,
    /// Number of bits that the object occupies in the PDO.
    pub bits: u8,
}

impl Mapped {
    /// The entry as encoded in the mapping parameter.
    pub const fn entry(self) -> u32 {
        (self.at.index.0 as u32) << 16 | (self.at.sub.0 as u32) << 8 | self.bits as u32
    }

    const fn from_entry(entry: u32) -> Self {
        Self { at: Multiplexer::new((entry >> 16) as u16, (entry >> 8) as u8), bits: entry as u8 }
    }
}

impl Pdo {
    /// The PDO with this number, from 1, in the same direction.
    pub const fn numbered(self, number: u16) -> Self {
        Self { communication: self.communication + number - 1, mapping: self.mapping + number - 1 }
    }

    /// The subject of a breach of this PDO as a whole.
    pub const fn subject(self) -> Subject {
        let transmit = self.communication >= TPDO.communication;
        let first = if transmit { TPDO.communication } else { RPDO.communication };
        Subject::Pdo { transmit, number: self.communication - first + 1 }
    }

    /// The multiplexer of a communication parameter: 1 COB-ID, 2 transmission type, 3 inhibit time, 5 event timer, 6
    /// SYNC start value.
    pub const fn parameter(self, sub: u8) -> Multiplexer {
        Multiplexer::new(self.communication, sub)
    }

    /// The multiplexer of a mapping parameter: 0 the number of objects, from 1 the objects.
    pub const fn entry(self, sub: u8) -> Multiplexer {
        Multiplexer::new(self.mapping, sub)
    }
}

impl Bench<'_> {
    /// The COB-ID of a PDO.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the COB-ID can't be read.
    pub(crate) fn pdo_cob_id(&mut self, pdo: Pdo) -> Result<CobId, Stop> {
        self.read_number(pdo.parameter(1)).map(CobId)
    }

    /// Switches a PDO off (bit 31 of its COB-ID); returns the earlier COB-ID.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses the write.
    pub(crate) fn pdo_off(&mut self, pdo: Pdo) -> Result<CobId, Stop> {
        let before = self.pdo_cob_id(pdo)?;
        self.write(pdo.parameter(1), &(before.0 | CobId::INVALID).to_le_bytes())?;
        Ok(before)
    }

    /// Switches a PDO on with the CAN-ID of a COB-ID, or with the predefined CAN-ID if the COB-ID has none.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses the write.
    pub(crate) fn pdo_on(&mut self, pdo: Pdo, cob_id: CobId) -> Result<(), Stop> {
        self.write(pdo.parameter(1), &self.valid_cob_id(pdo, cob_id).0.to_le_bytes())
    }

    /// Changes communication parameters while the PDO is off, and switches it on again with its CAN-ID. A timer that
    /// the device does not have counts as off: the tester writes no 0 to it.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses a write.
    pub(crate) fn set_pdo(&mut self, pdo: Pdo, parameters: &[(u8, &[u8])]) -> Result<(), Stop> {
        let cob_id = self.pdo_off(pdo)?;
        for (sub, value) in parameters {
            let is_off = *sub > 2 && value.iter().all(|&byte| byte == 0);
            if !is_off || self.has(pdo.parameter(*sub))? {
                self.write(pdo.parameter(*sub), value)?;
            }
        }
        self.pdo_on(pdo, cob_id)
    }

    /// Sets the event timer of a PDO. If the device refuses this while the PDO is on, the timer is set while the PDO is
    /// off.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses the write.
    pub(crate) fn set_event_timer(&mut self, pdo: Pdo, milliseconds: u16) -> Result<(), Stop> {
        let value = milliseconds.to_le_bytes();
        let attempt = self.download(pdo.parameter(5), &value)?;
        if attempt.abort().is_some() {
            return self.set_pdo(pdo, &[(5, &value)]);
        }
        attempt.expect_confirmation().or_inconclusive()
    }

    /// The mapping of a PDO.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the mapping can't be read.
    pub fn mapping(&mut self, pdo: Pdo) -> Result<Vec<Mapped>, Stop> {
        let count = self.read_number(pdo.entry(0))?;
        let subs = 1..=u8::try_from(count.min(64)).unwrap_or(0);
        subs.map(|sub| self.read_number(pdo.entry(sub)).map(Mapped::from_entry)).collect()
    }

    /// Requires that a PDO has a mapping as delivered: an empty PDO is not sent, and has no entry in use.
    ///
    /// # Errors
    /// [`Stop::NotApplicable`] if the mapping is empty, [`Stop::Inconclusive`] if it can't be read.
    pub(crate) fn require_mapped(&mut self, pdo: Pdo) -> Judged {
        if self.read_number(pdo.entry(0))? > 0 {
            return Ok(());
        }
        let duty = format!("{} carries an object as delivered", pdo.subject());
        Err(Stop::NotApplicable(Reason::new(duty, "one or more", "none")))
    }

    /// Requires at least one object that can be mapped.
    ///
    /// # Errors
    /// [`Stop::NotApplicable`] if `mapping` is empty.
    pub(crate) fn require_one(&self, pdo: Pdo, mapping: &[Mapped]) -> Judged {
        if !mapping.is_empty() {
            return Ok(());
        }
        let duty = format!("{} can carry an object", pdo.subject());
        Err(Stop::NotApplicable(Reason::new(duty, "one in the description", "none")))
    }

    /// Switches a PDO and its mapping off, so that entries can be written; returns the earlier COB-ID.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses a write.
    pub(crate) fn open_mapping(&mut self, pdo: Pdo) -> Result<CobId, Stop> {
        let cob_id = self.pdo_off(pdo)?;
        self.write(pdo.entry(0), &[0])?;
        Ok(cob_id)
    }

    /// Changes the mapping of a PDO in the five steps of CiA 301.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses a step.
    pub(crate) fn set_mapping(&mut self, pdo: Pdo, mapping: &[Mapped]) -> Result<(), Stop> {
        let cob_id = self.open_mapping(pdo)?;
        for (sub, mapped) in (1..=u8::MAX).zip(mapping) {
            self.write(pdo.entry(sub), &mapped.entry().to_le_bytes())?;
        }
        self.write(pdo.entry(0), &[u8::try_from(mapping.len()).unwrap_or(u8::MAX)])?;
        self.pdo_on(pdo, cob_id)
    }

    /// Sets this mapping and COB-ID of a PDO in the five steps of CiA 301. The device must confirm each step.
    ///
    /// # Errors
    /// [`Stop::Breach`] of the first step that the device refuses.
    pub fn remap(&mut self, pdo: Pdo, mapping: &[Mapped], cob_id: CobId) -> Judged {
        let off = (pdo.parameter(1), (cob_id.0 | CobId::INVALID).to_le_bytes().to_vec());
        let entries = (1..=u8::MAX).zip(mapping);
        let entries = entries.map(|(sub, mapped)| (pdo.entry(sub), mapped.entry().to_le_bytes().to_vec()));
        let count = u8::try_from(mapping.len()).unwrap_or(u8::MAX);
        let on = (pdo.parameter(1), self.valid_cob_id(pdo, cob_id).0.to_le_bytes().to_vec());
        let steps = [off, (pdo.entry(0), vec![0])].into_iter().chain(entries).chain([(pdo.entry(0), vec![count]), on]);
        for (multiplexer, value) in steps {
            self.download(multiplexer, &value)?.expect_confirmation()?;
            // Only the count is read back: some devices use the COB-ID that was last read.
            if multiplexer == pdo.entry(0) {
                self.expect_effect(multiplexer, &value)?;
            }
        }
        Ok(())
    }

    /// A value of an object that differs from `now`, within the limits of its description: the nearest such value.
    pub(crate) fn other_value(&self, at: Multiplexer, now: &[u8]) -> Vec<u8> {
        let flipped = || now.iter().enumerate().map(|(n, byte)| byte ^ u8::from(n == 0)).collect();
        let node = self.node();
        let entry = self.target.description.as_ref().and_then(|description| description.dictionary.entry(at).ok());
        let Some(entry) = entry else { return flipped() };
        let limit = |limit: Option<&canvass_analyzer::dictionary::Setting>| {
            limit.and_then(|limit| limit.resolve(entry.data_type, node).as_number())
        };
        let (low, high) = (limit(entry.low_limit.as_ref()), limit(entry.high_limit.as_ref()));
        let number = |value: &[u8]| Value::decode(entry.data_type, value).ok().and_then(|value| value.as_number());
        let fits = |value: &Vec<u8>| {
            let number = number(value);
            let is_high_enough = low.is_none_or(|low| number.is_none_or(|number| number >= low));
            value != now && is_high_enough && high.is_none_or(|high| number.is_none_or(|number| number <= high))
        };
        let encoded = |number: i128| number.to_le_bytes().into_iter().take(now.len()).collect();
        // At a limit, the value with the other lowest bit may be out of range.
        let next = number(now).into_iter().flat_map(|number| [number + 1, number - 1]);
        let others = next.chain([low, high].into_iter().flatten()).map(encoded);
        std::iter::once(flipped()).chain(others).find(fits).unwrap_or_else(flipped)
    }

    /// Whether a number is within the limits of the description.
    pub(crate) fn is_within_limits(&self, at: Multiplexer, number: i128) -> bool {
        let node = self.node();
        let entry = self.target.description.as_ref().and_then(|description| description.dictionary.entry(at).ok());
        let Some(entry) = entry else { return true };
        let limit = |limit: Option<&canvass_analyzer::dictionary::Setting>| {
            limit.and_then(|limit| limit.resolve(entry.data_type, node).as_number())
        };
        limit(entry.low_limit.as_ref()).is_none_or(|low| number >= low)
            && limit(entry.high_limit.as_ref()).is_none_or(|high| number <= high)
    }

    /// The inhibit time of a PDO; zero if it has none.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn pdo_inhibit_time(&mut self, pdo: Pdo) -> Result<Duration, Stop> {
        let units = match self.upload(pdo.parameter(3))?.outcome {
            canvass_bus::client::Outcome::Uploaded(value) => u64::from(number(&value)),
            _ => 0,
        };
        Ok(Duration::from_micros(100 * units))
    }

    /// Objects that a TPDO can carry according to the description, each with its length.
    pub(crate) fn tpdo_objects(&self) -> Vec<Mapped> {
        self.mappable(|entry| entry.access.allows_tpdo())
    }

    /// Objects that an RPDO can carry and SDO can read according to the description, so that the effect of an RPDO can
    /// be seen.
    pub(crate) fn rpdo_objects(&self) -> Vec<Mapped> {
        let mut objects = self.mappable(|entry| entry.access.allows_rpdo() && entry.access.is_readable());
        // A PDO with a preset would move the zero point with every frame.
        objects.retain(|mapped| !self.acts(mapped.at));
        objects
    }

    fn mappable(&self, allowed: impl Fn(&canvass_analyzer::dictionary::Entry) -> bool) -> Vec<Mapped> {
        let Some(description) = &self.target.description else { return Vec::new() };
        // Mappable communication objects, such as 1001h and 1013h, change by themselves.
        let entries = description.dictionary.entries();
        let entries = entries.filter(|(at, entry)| at.index.0 >= 0x2000 && entry.pdo_mappable && allowed(entry));
        let mapped = entries.filter_map(|(at, entry)| {
            // Whole bytes only: a BOOLEAN takes one bit in a PDO, but a byte in an SDO. No type of fixed length has
            // more than 64 bits.
            let bits = entry.data_type.bits().filter(|bits| bits % 8 == 0)?;
            Some(Mapped { at, bits: u8::try_from(bits).ok()? })
        });
        mapped.collect()
    }

    /// An object that a TPDO can carry and SDO can write, so that the tester can change its value. Returns also a value
    /// that differs from the current one.
    ///
    /// # Errors
    /// [`Stop::NotApplicable`] if the device has none.
    pub(crate) fn changeable(&mut self) -> Result<(Mapped, Vec<u8>), Stop> {
        let Some(mapped) = self.changeable_object() else {
            let duty = "an object that a TPDO carries can be written by SDO";
            return Err(Stop::NotApplicable(Reason::new(duty, "one in the description", "none")));
        };
        let before = self.read(mapped.at)?;
        let other = self.other_value(mapped.at, &before);
        self.uses(mapped.at, "mapped into TPDO 1, and written");
        Ok((mapped, other))
    }

    /// The object of [`Bench::changeable`], by the description.
    pub(crate) fn changeable_object(&self) -> Option<Mapped> {
        let mut objects = self.tpdo_objects();
        // Values that fit into an expedited SDO come first.
        objects.sort_by_key(|mapped| mapped.bits > 32);
        objects.into_iter().find(|mapped| self.is_described_as_writable(mapped.at))
    }

    /// The frames with this CAN-ID within `span`.
    ///
    /// # Errors
    /// The errors of [`Bench::wait_for`].
    pub(crate) fn frames_of(&mut self, can_id: u16, span: Duration) -> Result<Vec<Record>, Stop> {
        const MOST: usize = 20_000;
        let mut heard = Vec::new();
        self.wait_for(span, |record| {
            if record.frame.cob_id() == Some(can_id) && heard.len() < MOST {
                heard.push(record.clone());
            }
            None::<()>
        })?;
        Ok(heard)
    }

    /// Sets the SYNC period to 0, so that 1019h can be changed. A device that only consumes SYNC need not have 1006h.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses the write.
    pub(crate) fn stop_sync_period(&mut self) -> Result<(), Stop> {
        let period = Multiplexer::new(object::COMMUNICATION_CYCLE_PERIOD, 0);
        if self.has(period)? && self.read_number(period)? != 0 {
            self.write(period, &0_u32.to_le_bytes())?;
        }
        Ok(())
    }

    /// Configures the device for SYNC without data, if it expects a counter as delivered.
    ///
    /// # Errors
    /// [`Stop::Inconclusive`] if the device refuses the write.
    pub(crate) fn expect_plain_sync(&mut self) -> Result<(), Stop> {
        let overflow = Multiplexer::new(object::SYNCHRONOUS_COUNTER_OVERFLOW, 0);
        if self.has(overflow)? && self.read_number(overflow)? != 0 {
            self.stop_sync_period()?;
            self.write(overflow, &[0])?;
        }
        Ok(())
    }

    /// The CAN-ID of SYNC according to 1005h; the predefined one if the device has no 1005h.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub(crate) fn sync_id(&mut self) -> Result<u16, Stop> {
        let object = Multiplexer::new(object::COB_ID_SYNC, 0);
        if !self.has(object)? {
            return Ok(sync::CAN_ID);
        }
        Ok((number(&self.read(object)?) & 0x7FF) as u16)
    }
}
