//! Error conditions of a device, and their signals.

use crate::models::Quirks;
use canvass_analyzer::wire::emcy::{EmcyCode, ErrorRegister};

/// An error condition. Each is present or absent; only changes are reported.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Condition {
    /// The temperature is outside the limits of 2120h.
    Temperature { now: u8, low: u8, high: u8 },
    /// The shaft is too fast (6505h bit 0).
    Overspeed,
    /// The master's guarding requests are missing.
    Guarding,
    /// The position is wrong (6503h bit 0).
    Position,
    /// The heartbeat of that node is missing.
    Heartbeat { node: u8 },
    /// The RPDO of this number, from 1, is shorter than its mapping.
    RpdoTooShort { rpdo: u16 },
    /// The RPDO of this number, from 1, is longer than its mapping.
    RpdoTooLong { rpdo: u16 },
    /// The RPDO of this number, from 1, missed its deadline.
    RpdoLate { rpdo: u16 },
    /// SYNC does not have the length that 1019h requires.
    SyncLength,
    /// A parameter to be stored is outside its limits (6503h bit 13).
    Parameter,
    /// A hardware error, by its EMCY code in the model's sheet.
    Hardware { code: EmcyCode, register: u8, bytes: [u8; 5] },
}

impl Condition {
    /// The identity of the condition; other details may differ.
    pub const fn key(self) -> (u8, u16) {
        match self {
            Self::Temperature { .. } => (0, 0),
            Self::Overspeed => (1, 0),
            Self::Guarding => (2, 0),
            Self::Heartbeat { node } => (3, node as u16),
            Self::RpdoTooShort { rpdo } => (4, rpdo),
            Self::RpdoTooLong { rpdo } => (5, rpdo),
            Self::RpdoLate { rpdo } => (6, rpdo),
            Self::SyncLength => (7, 0),
            Self::Parameter => (8, 0),
            Self::Position => (9, 0),
            Self::Hardware { code, .. } => (10, code.0),
        }
    }

    pub fn code(self, quirks: &Quirks) -> EmcyCode {
        match self {
            Self::Temperature { .. } | Self::Overspeed => EmcyCode(0x4200),
            Self::Guarding => quirks.life_guarding_code(),
            Self::Heartbeat { .. } => EmcyCode::HEARTBEAT,
            Self::Parameter | Self::Position => EmcyCode::GENERIC,
            Self::RpdoTooShort { .. } => EmcyCode::PDO_LENGTH,
            Self::RpdoTooLong { .. } => EmcyCode::PDO_LENGTH_EXCEEDED,
            Self::RpdoLate { .. } => EmcyCode::RPDO_TIMEOUT,
            Self::SyncLength => EmcyCode::SYNC_LENGTH,
            Self::Hardware { code, .. } => code,
        }
    }

    /// The bit of 6503h.
    pub const fn alarm(self) -> u64 {
        match self {
            Self::Parameter => 1 << 13,
            _ => 0,
        }
    }

    /// The bits of the error register. Bit 0 is always among them, if the device supports it.
    pub fn register(self, quirks: &Quirks) -> u8 {
        if let Self::Hardware { register: documented @ 1.., .. } = self {
            return documented;
        }
        let is_alarm = matches!(self, Self::Parameter | Self::Position);
        let profile = if is_alarm { ErrorRegister::PROFILE.0 } else { 0 };
        // A lost master is a communication error, whatever its code.
        let communication = if matches!(self, Self::Guarding) { ErrorRegister::COMMUNICATION.0 } else { 0 };
        let bits = ErrorRegister::GENERIC.0 | self.code(quirks).register_bits() | communication | profile;
        match quirks.error_register_bits {
            None => bits,
            Some(own) if bits & own == 0 => own,
            Some(own) => bits & own,
        }
    }

    /// The sub-index of 1029h for the device's reaction.
    pub const fn behaviour(self) -> Option<u8> {
        match self {
            Self::Guarding | Self::Heartbeat { .. } => Some(1),
            Self::Temperature { .. } | Self::Overspeed => Some(2),
            // Temperature and sensor errors belong to the profile, communication errors to communication, others to
            // the manufacturer.
            Self::Hardware { code, .. } => Some(match code.0 {
                0x4000..0x5000 | 0x5050..0x5060 | 0xFF00 => 2,
                0x8000..0x9000 => 1,
                _ => 3,
            }),
            _ => None,
        }
    }

    /// Bytes 3 to 7.
    pub const fn manufacturer(self) -> [u8; 5] {
        match self {
            Self::Hardware { bytes, .. } => bytes,
            // Sensor error register, temperature, low and high threshold, sensor version.
            Self::Temperature { now, low, high } => [0x80, now, low, high, 0x2E],
            Self::RpdoTooShort { rpdo } | Self::RpdoTooLong { rpdo } | Self::RpdoLate { rpdo } => {
                let [low, high] = rpdo.to_le_bytes();
                [low, high, 0, 0, 0]
            }
            Self::Overspeed
            | Self::Guarding
            | Self::Heartbeat { .. }
            | Self::SyncLength
            | Self::Parameter
            | Self::Position => [0; 5],
        }
    }
}
