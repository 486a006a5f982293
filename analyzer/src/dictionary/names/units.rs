//! Physical units of objects, as far as a standard fixes them.

use super::profile::logical_device;
use crate::identity::Multiplexer;
use std::borrow::Cow;

/// A unit: physical value = raw value * factor + offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Unit {
    /// The number of units in one step of the raw value.
    pub factor: f64,
    /// The physical value of raw zero.
    pub offset: f64,
    /// The symbol, such as `ms` or `°C`.
    pub symbol: Cow<'static, str>,
}

impl Unit {
    /// A unit without offset.
    pub const fn new(factor: f64, symbol: &'static str) -> Self {
        Self { factor, offset: 0.0, symbol: Cow::Borrowed(symbol) }
    }

    /// The physical value of a raw one, rounded to six decimals: factors such as 0.1 have no exact binary form, and six
    /// digits are far more precise than any device.
    pub fn physical(&self, raw: f64) -> f64 {
        let value = raw.mul_add(self.factor, self.offset);
        (value * 1e6).round() / 1e6
    }

    /// Whether raw and physical values are the same numbers.
    pub(crate) fn is_raw(&self) -> bool {
        self.factor == 1.0 && self.offset == 0.0
    }
}

const MICROSECONDS: Unit = Unit::new(1.0, "µs");
const MILLISECONDS: Unit = Unit::new(1.0, "ms");
/// The unit of inhibit times: multiples of 100 µs.
const TENTHS_OF_MILLISECONDS: Unit = Unit::new(0.1, "ms");

/// The unit of an entry, if the standard fixes it.
pub fn unit(address: Multiplexer, profile: Option<u16>) -> Option<Unit> {
    Some(match (address.index.0, address.sub.0, profile) {
        (0x1006 | 0x1007 | 0x1013, 0, _) => MICROSECONDS,
        (0x100C | 0x1017 | 0x1F89, 0, _) | (0x1F90, 1 | 2 | 4..=6, _) => MILLISECONDS,
        (0x1015 | 0x102A, 0, _) => TENTHS_OF_MILLISECONDS,
        (0x1301..=0x1340, 2 | 3, _) => MILLISECONDS,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 3, _) => TENTHS_OF_MILLISECONDS,
        (0x1400..=0x15FF | 0x1800..=0x19FF, 5, _) => MILLISECONDS,
        (0x6000..=0x9FFF, _, Some(number)) => {
            let device = logical_device(address.index, number)?;
            return device.profile.unit(Multiplexer { index: device.object, ..address });
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        assert_eq!(unit(Multiplexer::new(0x1017, 0), None), Some(MILLISECONDS));
        assert_eq!(unit(Multiplexer::new(0x1800, 3), None), Some(TENTHS_OF_MILLISECONDS));
        assert_eq!(unit(Multiplexer::new(0x6000, 0), None), None);
    }
}
