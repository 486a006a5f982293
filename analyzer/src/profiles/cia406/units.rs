//! Units that the profile fixes.

use crate::dictionary::Unit;
use crate::identity::Multiplexer;

/// Measuring units of a position: their number per revolution or millimetre is configured.
const STEPS: Unit = Unit::new(1.0, "steps");

/// The unit of an entry, if the profile fixes it. Speeds have a configured unit and so none here.
pub(super) fn of(at: Multiplexer) -> Option<Unit> {
    Some(match (at.index.0, at.sub.0) {
        (0x6005, 1) => Unit::new(0.001, "µm"),
        (0x6005, 2) => Unit::new(0.01, "mm/s"),
        (0x6031 | 0x6041, 2) | (0x6200, 0) => Unit::new(1.0, "ms"),
        (0x6001..=0x6004 | 0x6501 | 0x6509, 0) | (0x6020 | 0x6401 | 0x6402 | 0x650A, 1..) => STEPS,
        (0x6502, 0) => Unit::new(1.0, "revolutions"),
        (0x6508, 0) => Unit::new(0.1, "h"),
        _ => return None,
    })
}
