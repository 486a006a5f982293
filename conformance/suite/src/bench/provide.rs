//! Provides a TPDO for cases that need one, if the device is delivered with its PDOs off or without mapping: TPDO 1 is
//! mapped and switched on as CiA 301 7.5.2.38 says, and put back after the case.

use super::objects::{TPDO_COB_ID, TPDO_FIRST_ENTRY, TPDO_MAPPED};
use super::pdo::{Mapped, Pdo, RPDO, TPDO};
use super::sdo::number;
use super::{Bench, Met};
use crate::verdict::Stop;
use canvass_analyzer::object;
use canvass_analyzer::wire::pdo;
use canvass_analyzer::{CobId, Multiplexer};
use canvass_bus::client::Outcome;

/// The error register. Every device has it, and many can map it.
const ERROR_REGISTER: Mapped = Mapped { at: Multiplexer::new(object::ERROR_REGISTER, 0), bits: 8 };

/// Maximum number of objects that are tried until the device accepts one.
const TRIED: usize = 4;

impl Bench<'_> {
    /// Makes sure that TPDO 1 is on and has a mapping. If the delivered TPDO 1 is off or empty, the bench sets it up
    /// for this case.
    ///
    /// # Errors
    /// The errors of [`Bench::has_all`].
    pub(crate) fn provide_tpdo(&mut self) -> Result<Met, Stop> {
        if let Err(why) = self.has_all(&[TPDO_COB_ID, TPDO_MAPPED])? {
            return Ok(Err(why));
        }
        let cob_id = CobId(number(&self.upload(TPDO_COB_ID)?.value()?));
        let mapped = number(&self.upload(TPDO_MAPPED)?.value()?);
        match (cob_id.is_valid(), mapped > 0) {
            (true, true) => Ok(Ok(())),
            (false, true) => self.switch_on(cob_id, &format!("TPDO 1 is switched off ({TPDO_COB_ID} is {cob_id})")),
            (_, false) => self.map_and_switch_on(cob_id),
        }
    }

    fn map_and_switch_on(&mut self, cob_id: CobId) -> Result<Met, Stop> {
        let state = format!("TPDO 1 maps no object ({TPDO_MAPPED} is 0)");
        if let Err(why) = self.can_write_all(&[TPDO_MAPPED, TPDO_FIRST_ENTRY])? {
            return Ok(Err(format!("{state}, and {why}")));
        }
        let candidates = self.tpdo_candidates();
        if candidates.is_empty() {
            return Ok(Err(format!("{state}, and the description names no object for it")));
        }
        if cob_id.is_valid()
            && let Err(why) = self.tried(TPDO_COB_ID, &(cob_id.0 | CobId::INVALID).to_le_bytes(), &state)?
        {
            return Ok(Err(why));
        }
        let mut refused = Ok(());
        for mapped in candidates {
            refused = self.tried(TPDO_FIRST_ENTRY, &mapped.entry().to_le_bytes(), &state)?;
            if refused.is_ok() {
                refused = self.tried(TPDO_MAPPED, &[1], &state)?;
            }
            if refused.is_ok() {
                self.uses(mapped.at, "mapped into TPDO 1");
                return self.switch_on(cob_id, &state);
            }
        }
        Ok(refused)
    }

    fn switch_on(&mut self, cob_id: CobId, state: &str) -> Result<Met, Stop> {
        if !self.can_write(TPDO_COB_ID)? {
            return Ok(Err(format!("{state}, and {TPDO_COB_ID} can't be written")));
        }
        let CobId(on) = self.valid_cob_id(TPDO, cob_id);
        let met = self.tried(TPDO_COB_ID, &on.to_le_bytes(), state)?;
        if met.is_ok() {
            self.uses(TPDO_COB_ID, "TPDO 1 is switched on for the case");
        }
        Ok(met)
    }

    /// Writes a value. Whether the device accepts it is judged by `301/pdo/mapping/procedure`.
    fn tried(&mut self, at: Multiplexer, value: &[u8], state: &str) -> Result<Met, Stop> {
        let outcome = self.download(at, value)?.outcome;
        Ok(match outcome {
            Outcome::Downloaded => Ok(()),
            other => Err(format!("{state}, and {at} can't be set: {other}")),
        })
    }

    /// Objects that TPDO 1 may carry, best first: objects that SDO can write, so that the tester can make the PDO
    /// change.
    fn tpdo_candidates(&self) -> Vec<Mapped> {
        let (mut found, others): (Vec<_>, Vec<_>) =
            self.tpdo_objects().into_iter().partition(|mapped| self.is_described_as_writable(mapped.at));
        found.extend(others);
        found.truncate(TRIED);
        let described = self.target.description.as_ref();
        let entry = described.and_then(|description| description.dictionary.entry(ERROR_REGISTER.at).ok());
        if described.is_none() || entry.is_some_and(|entry| entry.pdo_mappable) {
            found.push(ERROR_REGISTER);
        }
        found
    }

    /// The object that `301/pdo/mapping/procedure` maps if TPDO 1 has no mapping as delivered.
    pub(crate) fn tpdo_candidate(&self) -> Option<Mapped> {
        self.target.description.as_ref().and_then(|_| self.tpdo_candidates().first().copied())
    }

    /// The COB-ID of a PDO that is on: with its own CAN-ID, or with the predefined one if it has none.
    pub(crate) fn valid_cob_id(&self, pdo: Pdo, CobId(own): CobId) -> CobId {
        let bits = own & !CobId::INVALID;
        if bits & 0x1FFF_FFFF != 0 {
            return CobId(bits);
        }
        let predefined = match pdo {
            TPDO => pdo::TPDO_BASES[0],
            RPDO => pdo::RPDO_BASES[0],
            _ => return CobId(bits),
        };
        CobId(bits | u32::from(predefined + u16::from(self.node().raw())))
    }
}
