//! The features of the device, found out from its description and from the device itself.

use super::state::{GUARD_TIME, Heartbeats};
use super::{Bench, Met};
use crate::verdict::Stop;
use canvass_analyzer::Multiplexer;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_bus::client::Outcome;
use canvass_device::models::Model;

impl Bench<'_> {
    /// Whether the device has an object. Without a description the device decides: an object is absent if the answer is
    /// 0602 0000h or 0609 0011h, or if there is no answer.
    ///
    /// # Errors
    /// The errors of [`Bench::upload`].
    pub fn has(&mut self, multiplexer: Multiplexer) -> Result<bool, Stop> {
        if let Some(described) = self.described(multiplexer) {
            return Ok(described);
        }
        let outcome = self.upload(multiplexer)?.outcome;
        Ok(match outcome {
            Outcome::Aborted(abort) => !matches!(abort.code, AbortCode::NO_OBJECT | AbortCode::NO_SUB_INDEX),
            Outcome::Silent => false,
            _ => true,
        })
    }

    /// Whether the description contains an object; `None` without a description.
    pub fn described(&self, multiplexer: Multiplexer) -> Option<bool> {
        self.target.description.as_ref().map(|description| description.dictionary.entry(multiplexer).is_ok())
    }

    /// Whether the device has all of these objects.
    ///
    /// # Errors
    /// The errors of [`Bench::has`]; the breach if the device does not answer for an object: silence does not prove
    /// absence.
    pub fn has_all(&mut self, objects: &[Multiplexer]) -> Result<Met, Stop> {
        for &multiplexer in objects {
            let there = match self.described(multiplexer) {
                Some(described) => described,
                None => {
                    let attempt = self.upload(multiplexer)?;
                    match attempt.abort() {
                        Some(code) => !matches!(code, AbortCode::NO_OBJECT | AbortCode::NO_SUB_INDEX),
                        None => attempt.value().map(|_| true)?,
                    }
                }
            };
            if !there {
                return Ok(Err(format!("the device has no {multiplexer}")));
            }
        }
        Ok(Ok(()))
    }

    /// Whether all of these objects can be written.
    ///
    /// # Errors
    /// The errors of [`Bench::has_all`].
    pub(crate) fn can_write_all(&mut self, objects: &[Multiplexer]) -> Result<Met, Stop> {
        if let Err(why) = self.has_all(objects)? {
            return Ok(Err(why));
        }
        for &multiplexer in objects {
            if !self.can_write(multiplexer)? {
                return Ok(Err(format!("{multiplexer} can't be written")));
            }
        }
        Ok(Ok(()))
    }

    /// Whether the device has an object and its description does not call it read-only.
    ///
    /// # Errors
    /// The errors of [`Bench::has`].
    pub(crate) fn can_write(&mut self, multiplexer: Multiplexer) -> Result<bool, Stop> {
        if !self.is_described_as_writable(multiplexer) || !self.has(multiplexer)? {
            return Ok(false);
        }
        if self.target.description.is_some() {
            return Ok(true);
        }
        // Without a description, the tester writes the object's own value again.
        let Outcome::Uploaded(value) = self.upload(multiplexer)?.outcome else { return Ok(false) };
        let refusal = self.download(multiplexer, &value)?.abort();
        Ok(!matches!(refusal, Some(AbortCode::READ_ONLY | AbortCode::UNSUPPORTED_ACCESS)))
    }

    /// Whether life guarding can be configured, and the device has no heartbeat that can't be ended: such a heartbeat
    /// rules life guarding out.
    ///
    /// # Errors
    /// The errors of [`Bench::has`].
    pub(crate) fn can_be_guarded(&mut self) -> Result<bool, Stop> {
        let is_settable =
            self.can_write(GUARD_TIME)? && self.can_write(Multiplexer::new(object::LIFE_TIME_FACTOR, 0))?;
        Ok(is_settable && !matches!(self.heartbeats()?, Heartbeats::Fixed(_)))
    }

    /// Whether the device keeps the bit rate with which it starts: nobody has configured another one, or the object for
    /// the bit rate, if the device has one, still holds its value from before the run.
    pub(crate) fn keeps_bit_rate(&mut self) -> bool {
        if !self.traffic.watch.has_configured_bit_rate() {
            return true;
        }
        let Some(at) = self.target.manual.settings.bit_rate else { return false };
        let stored = self.changes.baseline.stored.iter().flatten().find(|original| original.at == at);
        let Some(before) = stored.map(|original| original.value.clone()) else { return false };
        matches!(self.unjudged(|bench| bench.value_at_last(at)), Ok(Some(now)) if now == before)
    }

    /// The manual of the device, if it is a built-in model.
    pub(crate) fn manual(&self) -> Option<&'static Model> {
        Model::by_id(&self.target.model)
    }

    /// A node-ID next to the device's own at which no other node was heard.
    pub(crate) fn vacant_neighbour(&self) -> Option<u8> {
        let own = self.node().raw();
        let candidates = [own.checked_add(1), own.checked_sub(1), own.checked_add(2), own.checked_sub(2)];
        let vacant = |raw: &u8| {
            canvass_analyzer::NodeId::new(*raw).is_some_and(|node| !self.traffic.watch.others().contains(&node))
        };
        candidates.into_iter().flatten().find(vacant)
    }
}
