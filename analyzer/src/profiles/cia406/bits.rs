//! The bits of registers. Manufacturer-specific bits have no name.

use super::objects;
use crate::identity::Index;

/// Bits of 6000h and 6500h; bits 12 to 15 belong to the manufacturer.
const OPERATING: &[&str] = &[
    "code sequence counter-clockwise",
    "commissioning diagnostic control",
    "scaling function",
    "measuring direction reversed",
];

/// Bits of 6503h and 6504h; bits 12 to 15 belong to the manufacturer.
const ALARMS: &[&str] = &["position error", "commissioning diagnostic control"];

/// Bits of 6505h and 6506h; bits 12 to 15 belong to the manufacturer.
const WARNINGS: &[&str] = &[
    "frequency exceeded",
    "light control reserve",
    "CPU watchdog status",
    "operating time limit",
    "battery charge",
    "reference point not reached",
];

/// Bits of 6400h.
const AREA_STATE: &[&str] = &["out of range", "range overflow", "range underflow"];

/// Bits of 6300h to 6302h.
const CAMS: &[&str] = &["cam 1", "cam 2", "cam 3", "cam 4", "cam 5", "cam 6", "cam 7", "cam 8"];

/// The names of the bits of an object, from bit 0 on.
pub(super) const fn of(index: Index) -> &'static [&'static str] {
    match index.0 {
        objects::OPERATING_PARAMETERS | objects::OPERATING_STATUS => OPERATING,
        objects::CAM_STATE..=objects::CAM_POLARITY => CAMS,
        objects::WORK_AREA_STATE => AREA_STATE,
        objects::ALARMS | objects::SUPPORTED_ALARMS => ALARMS,
        objects::WARNINGS | objects::SUPPORTED_WARNINGS => WARNINGS,
        _ => &[],
    }
}

/// The object that a manual describes for both: the status shows the parameters, and what is supported is what can be set.
pub(super) const fn same(index: Index) -> Option<Index> {
    Some(Index(match index.0 {
        objects::OPERATING_STATUS => objects::OPERATING_PARAMETERS,
        objects::SUPPORTED_ALARMS => objects::ALARMS,
        objects::SUPPORTED_WARNINGS => objects::WARNINGS,
        _ => return None,
    }))
}
