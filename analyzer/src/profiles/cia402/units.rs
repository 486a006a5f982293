//! Units that do not depend on the drive's configuration.

use crate::dictionary::Unit;
use crate::identity::Multiplexer;

/// A thousandth of the rated torque or current.
const TENTH_OF_PERCENT: Unit = Unit::new(0.1, "% of rated");

/// The unit of an entry, if the profile fixes it. Positions, velocities and accelerations have configured units.
pub(super) fn of(at: Multiplexer) -> Option<Unit> {
    Some(match (at.index.0, at.sub.0) {
        (0x6066 | 0x6068 | 0x606E | 0x6070, 0) => Unit::new(1.0, "ms"),
        (0x6071..=0x6074 | 0x6077 | 0x6078 | 0x60B2 | 0x60E0 | 0x60E1, 0) => TENTH_OF_PERCENT,
        (0x6075, 0) => Unit::new(1.0, "mA"),
        (0x6076, 0) => Unit::new(1.0, "mNm"),
        (0x6079, 0) => Unit::new(1.0, "mV"),
        _ => return None,
    })
}
