//! Error conditions of a device, and their signals.

use super::application::ApplicationError;
use crate::models::Quirks;
use canvass_analyzer::wire::emcy::{EmcyCode, ErrorRegister};

/// An error condition. Each is present or absent; only changes are reported.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Condition {
    /// An error of the device's application.
    Application(ApplicationError),
    /// The master's guarding requests are missing.
    Guarding,
    /// The heartbeat of this node is missing.
    Heartbeat { node: u8 },
    /// The RPDO of this number, from 1, is shorter than its mapping.
    RpdoTooShort { rpdo: u16 },
    /// The RPDO of this number, from 1, is longer than its mapping.
    RpdoTooLong { rpdo: u16 },
    /// The RPDO of this number, from 1, missed its deadline.
    RpdoLate { rpdo: u16 },
    /// SYNC does not have the length that 1019h requires.
    SyncLength,
    /// A parameter to be stored is outside its limits.
    Parameter,
    /// A hardware error, by its EMCY code in the model's sheet.
    Hardware { code: EmcyCode, register: u8, bytes: [u8; 5] },
}

impl Condition {
    /// The identity of the condition: conditions with equal keys are the same condition, whatever their other fields.
    pub const fn key(self) -> (u8, u16) {
        match self {
            Self::Application(error) => (0, error.number),
            Self::Guarding => (2, 0),
            Self::Heartbeat { node } => (3, node as u16),
            Self::RpdoTooShort { rpdo } => (4, rpdo),
            Self::RpdoTooLong { rpdo } => (5, rpdo),
            Self::RpdoLate { rpdo } => (6, rpdo),
            Self::SyncLength => (7, 0),
            Self::Parameter => (8, 0),
            Self::Hardware { code, .. } => (10, code.0),
        }
    }

    pub fn code(self, quirks: &Quirks) -> EmcyCode {
        match self {
            Self::Application(error) => error.code,
            Self::Guarding => quirks.life_guarding_code(),
            Self::Heartbeat { .. } => EmcyCode::HEARTBEAT,
            Self::Parameter => EmcyCode::GENERIC,
            Self::RpdoTooShort { .. } => EmcyCode::PDO_LENGTH,
            Self::RpdoTooLong { .. } => EmcyCode::PDO_LENGTH_EXCEEDED,
            Self::RpdoLate { .. } => EmcyCode::RPDO_TIMEOUT,
            Self::SyncLength => EmcyCode::SYNC_LENGTH,
            Self::Hardware { code, .. } => code,
        }
    }

    /// The bits that the condition sets in the error register: bit 0 and the bits of its kind, as far as the device
    /// supports them.
    pub fn register(self, quirks: &Quirks) -> u8 {
        if let Self::Hardware { register: documented @ 1.., .. } = self {
            return documented;
        }
        let of_profile = match self {
            Self::Parameter => ErrorRegister::PROFILE.0,
            Self::Application(error) => error.register,
            _ => 0,
        };
        // The loss of the master is a communication error, whatever its EMCY code.
        let communication = if matches!(self, Self::Guarding) { ErrorRegister::COMMUNICATION.0 } else { 0 };
        let bits = ErrorRegister::GENERIC.0 | self.code(quirks).register_bits() | communication | of_profile;
        match quirks.error_register_bits {
            None => bits,
            Some(own) if bits & own == 0 => own,
            Some(own) => bits & own,
        }
    }

    /// The sub-index of 1029h that sets the device's reaction.
    pub const fn behaviour(self) -> Option<u8> {
        match self {
            Self::Guarding | Self::Heartbeat { .. } => Some(1),
            Self::Application(error) => error.behaviour,
            // 1029h:01 is for communication errors, 1029h:02 for errors of the profile (temperature, sensor), 1029h:03
            // for errors of the manufacturer.
            Self::Hardware { code, .. } => Some(match code.0 {
                0x4000..0x5000 | 0x5050..0x5060 | 0xFF00 => 2,
                0x8000..0x9000 => 1,
                _ => 3,
            }),
            _ => None,
        }
    }

    /// Bytes 3 to 7 of the EMCY message.
    pub const fn manufacturer(self) -> [u8; 5] {
        match self {
            Self::Hardware { bytes, .. } => bytes,
            Self::Application(error) => error.manufacturer,
            Self::RpdoTooShort { rpdo } | Self::RpdoTooLong { rpdo } | Self::RpdoLate { rpdo } => {
                let [low, high] = rpdo.to_le_bytes();
                [low, high, 0, 0, 0]
            }
            Self::Guarding | Self::Heartbeat { .. } | Self::SyncLength | Self::Parameter => [0; 5],
        }
    }
}
