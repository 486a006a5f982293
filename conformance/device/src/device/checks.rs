//! Checks of written numbers: limits, rules of the service, and rules of the model's sheet.

use super::emcy::{check_cob_id, check_peer_cob_id};
use super::lss_slave::UNCONFIGURED;
use super::objects::Objects;
use super::store::StoreCommand;
use super::{heartbeat_consumer, pdo, sync, time};
use crate::Fault;
use crate::models::Rule;
use canvass_analyzer::object;
use canvass_analyzer::object::encoder;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};
use std::cmp::Ordering;

/// Bit 2 of 6000h.
const SCALING: u64 = 1 << 2;

impl Objects {
    /// Checks whether the object accepts that number now.
    ///
    /// # Errors
    /// The abort code of this model if it does not.
    pub(super) fn check(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        if let Some(command) = StoreCommand::of(at, &self.model.sheet().storage) {
            return self.check_signature(at, command, value);
        }
        // The number of mapped objects has abort codes of its own.
        if object::is_pdo_mapping(at.index.0) {
            return pdo::check_mapping(at, value, self);
        }
        if self.encoder.as_ref().is_some_and(|encoder| encoder.wedges(at, value)) {
            return Ok(());
        }
        self.check_bus_object(at, value)?;
        let reserved = at.index.0 == object::ERROR_BEHAVIOR && self.firmware.has(Fault::ErrorBehaviourUnchecked);
        if !self.firmware.has(Fault::SdoRangeUnchecked) && !reserved && !self.is_checked_later(at) {
            self.parameters.entry(at)?.check_range(value)?;
        }
        self.check_communication(at, value)?;
        self.check_application(at, value)
    }

    fn check_signature(&self, at: Multiplexer, command: StoreCommand, value: u64) -> Result<(), AbortCode> {
        if at.sub.0 > 1 && self.firmware.has(Fault::StoreSignatureFirstOnly) {
            return Ok(());
        }
        let checked = match command {
            // With this fault, one check accepts both signatures.
            _ if self.firmware.has(Fault::StoreSignatureUnchecked) => false,
            StoreCommand::Save(_) => true,
            StoreCommand::Restore(_) => !self.firmware.has(Fault::RestoreSignatureUnchecked),
        };
        if checked { command.check(value, &self.model.sheet().storage) } else { Ok(()) }
    }

    /// Checks node-ID and bit rate: a valid value, or "not configured" if the device is delivered so.
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
        if exists || of_device || self.firmware.has(Fault::SdoRangeUnchecked) {
            Ok(())
        } else {
            Err(AbortCode::INVALID_VALUE)
        }
    }

    /// Checks objects from 1000h to 1FFFh.
    fn check_communication(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        let (parameters, firmware, network) = (&self.parameters, &self.firmware, &self.model.sheet().network);
        let old = || CobId(parameters.number_or_zero(at.index.0, at.sub.0) as u32);
        match (at.index.0, at.sub.0) {
            (object::PREDEFINED_ERROR_FIELD, _) if value != 0 && !firmware.has(Fault::ErrorHistoryNonZeroAccepted) => {
                Err(AbortCode::INVALID_VALUE)
            }
            (object::COB_ID_SYNC, _) => sync::check_cob_id(value, parameters, network, firmware),
            (object::COMMUNICATION_CYCLE_PERIOD, _) => sync::check_period(value, network),
            (object::COB_ID_TIME, _) => time::check(value, parameters, network, firmware),
            (object::COB_ID_EMCY, _) => check_cob_id(value, parameters, firmware),
            (object::CONSUMER_HEARTBEAT_TIME, 1..) => {
                let code = self.model.sheet().abort(Rule::OneConsumerPerNode, at);
                heartbeat_consumer::check(at, value, parameters, firmware).map_err(|_| code)
            }
            (object::SYNCHRONOUS_COUNTER_OVERFLOW, _) => sync::check_overflow(value, parameters, firmware),
            (object::EMERGENCY_CONSUMER, 1..) => {
                check_peer_cob_id(value, old(), firmware, !firmware.has(Fault::EmcyIdChangeWhileValid))
            }
            (object::ERROR_BEHAVIOR, 1..) if value > 2 && !firmware.has(Fault::ErrorBehaviourUnchecked) => {
                Err(firmware.limit_code())
            }
            (object::SDO_SERVER_PARAMETER..object::SDO_CLIENT_PARAMETER, 1 | 2) => {
                check_peer_cob_id(value, old(), firmware, !firmware.has(Fault::SdoChannelIdChangeWhileValid))
            }
            (
                object::RPDO_COMMUNICATION_PARAMETER..object::RPDO_MAPPING_PARAMETER
                | object::TPDO_COMMUNICATION_PARAMETER..object::TPDO_MAPPING_PARAMETER,
                _,
            ) => pdo::check_communication(at, value, self),
            _ => Ok(()),
        }
    }

    /// Checks by the encoder's rules and the sheet.
    fn check_application(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        let sheet = self.model.sheet();
        self.compare(at, value)?;
        let Some(encoder) = &self.encoder else { return Ok(()) };
        let quirks = &sheet.quirks;
        match at.index.0 {
            encoder::PRESET_VALUE => {
                let code = sheet.abort(Rule::InsideActiveRange, at);
                encoder.check(at, value, &self.parameters).map_err(|_| code)
            }
            0x6000.. if self.is_checked_later(at) => self.check_scaling_bit(),
            encoder::UNITS_PER_REVOLUTION | encoder::TOTAL_MEASURING_RANGE if quirks.scaling_bit_guards => {
                self.check_scaling_bit()
            }
            encoder::UNITS_PER_REVOLUTION | encoder::TOTAL_MEASURING_RANGE => {
                let code = sheet.abort(Rule::UnitsAtMostRange, at);
                encoder.check(at, value, &self.parameters).map_err(|_| code)
            }
            0x6000.. => encoder.check(at, value, &self.parameters),
            _ => Ok(()),
        }
    }

    /// Whether the limits of the object are checked only when it is stored.
    fn is_checked_later(&self, at: Multiplexer) -> bool {
        let quirks = &self.model.sheet().quirks;
        quirks.limits_checked_at_store && quirks.acts_when_stored.contains(&at)
    }

    fn check_scaling_bit(&self) -> Result<(), AbortCode> {
        let guarded = self.model.sheet().quirks.scaling_bit_guards;
        let is_on = self.parameters.number_or_zero(encoder::OPERATING_PARAMETERS, 0) & SCALING != 0;
        if is_on || !guarded { Ok(()) } else { Err(AbortCode::UNSUPPORTED_ACCESS) }
    }

    /// A faulty firmware accepts a work area whose low limit is above its high limit.
    fn is_swap_accepted(&self, at: Multiplexer) -> bool {
        matches!(at.index.0, encoder::WORK_AREA_LOW_LIMIT | encoder::WORK_AREA_HIGH_LIMIT)
            && self.firmware.has(Fault::WorkAreaLimitsSwappedAccepted)
    }

    /// Checks objects that limit each other.
    fn compare(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        let entry = self.parameters.entry(at)?;
        for check in self.model.sheet().checks.iter().filter(|check| check.at.contains(at)) {
            let other = check.of.and_then(|of| self.parameters.number(of.index.0, of.sub.0));
            let ordering = other.and_then(|other| entry.compare(value, other));
            match (check.rule, ordering) {
                (Rule::AtMost, Some(Ordering::Greater)) | (Rule::AtLeast, Some(Ordering::Less))
                    if !self.is_swap_accepted(at) =>
                {
                    return Err(check.abort);
                }
                _ => {}
            }
        }
        Ok(())
    }
}
