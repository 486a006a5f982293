//! Checks of written numbers: limits, rules of the service, and rules of the model's sheet.

use super::emcy::{check_cob_id, check_peer_cob_id};
use super::lss_slave::UNCONFIGURED;
use super::objects::Objects;
use super::store::StoreCommand;
use super::{heartbeat_consumer, pdo, sync, time};
use crate::Fault;
use crate::models::Rule;
use canvass_analyzer::object;
use canvass_analyzer::wire::sdo::AbortCode;
use canvass_analyzer::{CobId, Multiplexer};
use std::cmp::Ordering;

impl Objects {
    /// Checks whether the object accepts a number now.
    ///
    /// # Errors
    /// The abort code of this model if the object does not accept the number.
    pub(super) fn check(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        if let Some(command) = StoreCommand::of(at, &self.model.sheet().storage) {
            return self.check_signature(at, command, value);
        }
        // The number of mapped objects has abort codes of its own.
        if object::is_pdo_mapping(at.index.0) {
            return pdo::check_mapping(at, value, self);
        }
        if self.application.as_ref().is_some_and(|application| application.wedges(at, value)) {
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
            // A firmware with this fault accepts any signature.
            _ if self.firmware.has(Fault::StoreSignatureUnchecked) => false,
            StoreCommand::Save(_) => true,
            StoreCommand::Restore(_) => !self.firmware.has(Fault::RestoreSignatureUnchecked),
        };
        if checked { command.check(value, &self.model.sheet().storage) } else { Ok(()) }
    }

    /// Checks node-ID and bit rate: the value must be valid; "not configured" is valid if the device is delivered
    /// without node-ID.
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

    /// Checks a value by the application's rules and the sheet.
    fn check_application(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        self.compare(at, value)?;
        match &self.application {
            Some(application) => application.check(at, value, &self.surroundings()),
            None => Ok(()),
        }
    }

    /// Whether the limits of the object are checked only when it is stored.
    fn is_checked_later(&self, at: Multiplexer) -> bool {
        self.model.sheet().quirks.is_checked_later(at)
    }

    /// Checks objects that limit each other.
    fn compare(&self, at: Multiplexer, value: u64) -> Result<(), AbortCode> {
        let entry = self.parameters.entry(at)?;
        let overlooked = || self.application.as_ref().is_some_and(|application| application.overlooks_limits(at));
        for check in self.model.sheet().checks.iter().filter(|check| check.at.contains(at)) {
            let other = check.of.and_then(|of| self.parameters.number(of.index.0, of.sub.0));
            let ordering = other.and_then(|other| entry.compare(value, other));
            match (check.rule, ordering) {
                (Rule::AtMost, Some(Ordering::Greater)) | (Rule::AtLeast, Some(Ordering::Less)) if !overlooked() => {
                    return Err(check.abort);
                }
                _ => {}
            }
        }
        Ok(())
    }
}
