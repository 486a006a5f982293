//! The bits of registers that a standard defines.

use super::ENCODER_PROFILE;
use crate::identity::Index;

/// Bits 0 to 7 of 1001h, and of the error register in an EMCY.
const ERROR_REGISTER: &[&str] = &[
    "generic error",
    "current",
    "voltage",
    "temperature",
    "communication error",
    "device profile specific",
    "reserved",
    "manufacturer specific",
];

/// 6000h and 6500h; bits 12 to 15 belong to the manufacturer.
const OPERATING: &[&str] = &[
    "code sequence counter-clockwise",
    "commissioning diagnostic control",
    "scaling function",
    "measuring direction reversed",
];

/// 6503h and 6504h; bits 12 to 15 belong to the manufacturer.
const ALARMS: &[&str] = &["position error", "commissioning diagnostic control"];

/// 6505h and 6506h; bits 12 to 15 belong to the manufacturer.
const WARNINGS: &[&str] = &[
    "frequency exceeded",
    "light control reserve",
    "CPU watchdog status",
    "operating time limit",
    "battery charge",
    "reference point not reached",
];

/// 6400h.
const AREA_STATE: &[&str] = &["out of range", "range overflow", "range underflow"];

/// 6300h to 6302h.
const CAMS: &[&str] = &["cam 1", "cam 2", "cam 3", "cam 4", "cam 5", "cam 6", "cam 7", "cam 8"];

/// The name of an object's bit, if the standard defines it; manufacturer-specific bits have none.
pub fn bit_name(index: Index, bit: u8, profile: Option<u16>) -> Option<&'static str> {
    let names = match (index.0, profile) {
        (0x1001, _) => ERROR_REGISTER,
        (0x6000 | 0x6500, Some(ENCODER_PROFILE)) => OPERATING,
        (0x6300..=0x6302, Some(ENCODER_PROFILE)) => CAMS,
        (0x6400, Some(ENCODER_PROFILE)) => AREA_STATE,
        (0x6503 | 0x6504, Some(ENCODER_PROFILE)) => ALARMS,
        (0x6505 | 0x6506, Some(ENCODER_PROFILE)) => WARNINGS,
        _ => return None,
    };
    names.get(usize::from(bit)).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_have_names() {
        assert_eq!(bit_name(Index(0x1001), 4, None), Some("communication error"));
        assert_eq!(bit_name(Index(0x6000), 2, Some(406)), Some("scaling function"));
        assert_eq!((bit_name(Index(0x6000), 13, Some(406)), bit_name(Index(0x6000), 2, Some(401))), (None, None));
    }
}
