//! How the shaft of a simulated encoder moves.

use canvass_traces::Timestamp;

/// A motion at constant speed.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Motion {
    /// The position at time 0, in steps of the physical resolution.
    pub start: i64,
    /// Thousandths of a revolution per minute; negative is counter-clockwise. 0: the shaft stands still.
    pub milli_rpm: i64,
}

impl Motion {
    /// A shaft that stands still at that position.
    pub const fn still(position: i64) -> Self {
        Self { start: position, milli_rpm: 0 }
    }

    /// Whether it moves at all.
    pub const fn is_still(self) -> bool {
        self.milli_rpm == 0
    }

    /// The position in steps since time 0, over all revolutions.
    pub fn position(self, now: Timestamp, steps_per_revolution: u64) -> i128 {
        // rpm / 1000 / 60 s / 10^9 ns
        const PER_NANOSECOND: i128 = 1_000 * 60 * 1_000_000_000;
        let turned = i128::from(self.milli_rpm) * i128::from(now.nanos()) * i128::from(steps_per_revolution);
        i128::from(self.start) + turned.div_euclid(PER_NANOSECOND)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_revolution_per_second() {
        let motion = Motion { start: 100, milli_rpm: 60_000 };
        assert_eq!(motion.position(Timestamp(1_000_000_000), 8192), 100 + 8192);
        assert_eq!(motion.position(Timestamp(500_000_000), 8192), 100 + 4096);
        let back = Motion { start: 0, milli_rpm: -60_000 };
        assert_eq!(back.position(Timestamp(1_000_000_000), 8192), -8192);
        assert!(Motion::still(3).is_still());
    }
}
