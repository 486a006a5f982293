//! The rhythm of a PDO that follows SYNC: how many SYNC messages come from one frame to the next. It is learned from the
//! frames.

/// The learned number of SYNC messages, and the state of the comparison.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pace {
    /// Number of SYNC messages on the bus until the last frame.
    at: u32,
    /// Number of SYNC messages from a frame to the next one; 0 before it is known.
    step: u32,
    /// Number of frames that had this step.
    regular: u32,
    /// Number of these frames with unchanged data: no event has sent them.
    unchanged: u32,
    /// Number of SYNC messages before an additional frame. They count for the next frame, too.
    carry: u32,
    /// Number of regular frames that must still come before an odd frame counts as a single event; 0 without one.
    waits: u8,
}

/// A frame that is out of step with SYNC.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Odd {
    /// The usual number of SYNC messages between two frames.
    pub step: u32,
    /// The number before this frame.
    pub passed: u32,
}

/// The result of the comparison of a frame with the learned step.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Beat {
    /// The frame has the learned step, or no step is learned yet.
    Usual,
    /// The frame is odd; the next frames show whether the PDO keeps its step.
    Odd(Odd),
    /// With this frame the PDO has kept its step since an odd frame: that one was a single event.
    Kept,
}

impl Pace {
    /// Number of frames from which a step is certain.
    const CERTAIN: u32 = 30;
    /// Number of frames with unchanged data that show that no event sends the PDO.
    const UNCHANGED: u32 = 10;
    /// More SYNC messages than this number of steps are a pause, for which other rules exist.
    const PAUSE: u32 = 10;
    /// Number of regular frames after which an odd one is a single event.
    const KEPT: u8 = 3;

    /// Whether the PDO comes with SYNC.
    pub const fn is_certain(&self) -> bool {
        self.regular >= Self::CERTAIN
    }

    /// Handles a frame, after `syncs` SYNC messages on the bus.
    pub fn beat(&mut self, syncs: u32, is_same: bool) -> Beat {
        let passed = syncs.wrapping_sub(std::mem::replace(&mut self.at, syncs));
        let whole = passed.saturating_add(std::mem::take(&mut self.carry));
        if whole == self.step && self.step > 0 {
            self.regular = self.regular.saturating_add(1);
            self.unchanged = self.unchanged.saturating_add(u32::from(is_same));
            let waited = self.waits;
            self.waits = waited.saturating_sub(1);
            return if waited == 1 { Beat::Kept } else { Beat::Usual };
        }
        let is_additional = passed < self.step;
        let is_left_out = self.unchanged >= Self::UNCHANGED && passed < self.step.saturating_mul(Self::PAUSE);
        // Two odd frames soon after each other are no single event: the step is learned anew.
        if !self.is_certain() || self.waits > 0 || !is_additional && !is_left_out {
            *self = Self { at: syncs, step: passed, ..Self::default() };
            return Beat::Usual;
        }
        self.carry = if is_additional { passed } else { 0 };
        self.waits = Self::KEPT;
        Beat::Odd(Odd { step: self.step, passed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The single odd frames of a PDO that comes after these numbers of SYNC messages.
    fn odd(steps: impl IntoIterator<Item = u32>) -> Vec<(u32, u32)> {
        let (mut pace, mut syncs, mut last) = (Pace::default(), 0, None);
        let mut found = Vec::new();
        for step in steps {
            syncs += step;
            match pace.beat(syncs, true) {
                Beat::Odd(odd) => last = Some((odd.step, odd.passed)),
                Beat::Kept => found.extend(last.take()),
                Beat::Usual => {}
            }
        }
        found
    }

    #[test]
    fn a_frame_that_is_left_out_or_additional() {
        let steady = || std::iter::repeat_n(2, 40);
        assert_eq!(odd(steady().chain([4]).chain(steady())), [(2, 4)]);
        assert_eq!(odd(steady().chain([1, 1]).chain(steady())), [(2, 1)]);
        assert_eq!(odd(steady().chain([0, 2]).chain(steady())), [(2, 0)]);
        // Twice the rate, another step, and too few frames.
        assert_eq!(odd(steady().chain([1; 40])), []);
        assert_eq!(odd(std::iter::repeat_n(1, 40).chain([1, 0].repeat(40))), []);
        assert_eq!(odd(steady().chain(std::iter::repeat_n(3, 40))), []);
        assert_eq!(odd([2, 2, 2, 4, 2, 2]), []);
    }
}
