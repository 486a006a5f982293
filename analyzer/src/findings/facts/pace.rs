//! The number of SYNC messages between the frames of a PDO, as it is learned from its frames.

/// Follows one PDO.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pace {
    /// Number of SYNC messages on the bus until the last frame.
    at: u32,
    /// Number of SYNC messages from a frame to the next one; 0 before it is known.
    step: u32,
    /// Number of frames in a row that had this step.
    regular: u32,
    /// Number of these frames with the data of the frame before: no event has sent them.
    unchanged: u32,
    /// Number of SYNC messages that belong to the step of the next frame, because another frame came between.
    carry: u32,
    /// The last frame, if it did not have the step: it counts once the next frame has it again.
    odd: Option<Odd>,
}

/// A frame that came with another number of SYNC messages.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Odd {
    /// The usual number of SYNC messages between two frames.
    pub step: u32,
    /// The number before this frame.
    pub passed: u32,
}

impl Pace {
    /// Number of frames from which a step is certain.
    const CERTAIN: u32 = 30;
    /// Number of frames with unchanged data that show that no event sends the PDO.
    const UNCHANGED: u32 = 10;
    /// More SYNC messages than this number of steps are a pause, for which other rules exist.
    const PAUSE: u32 = 10;

    /// Whether the PDO comes with SYNC.
    pub fn is_certain(&self) -> bool {
        self.regular >= Self::CERTAIN
    }

    /// Handles a frame, after `syncs` SYNC messages on the bus. Returns the frame before this one if it was odd, and
    /// this one shows that the PDO keeps its step.
    pub fn beat(&mut self, syncs: u32, is_same: bool) -> Option<Odd> {
        let passed = syncs.wrapping_sub(std::mem::replace(&mut self.at, syncs));
        let whole = passed.saturating_add(std::mem::take(&mut self.carry));
        if whole == self.step && self.step > 0 {
            self.regular = self.regular.saturating_add(1);
            self.unchanged = self.unchanged.saturating_add(u32::from(is_same));
            return self.odd.take();
        }
        let is_additional = passed < self.step;
        let counts = self.is_certain()
            && self.odd.is_none()
            && (is_additional || self.unchanged >= Self::UNCHANGED && passed < self.step.saturating_mul(Self::PAUSE));
        if counts {
            self.odd = Some(Odd { step: self.step, passed });
            self.carry = if is_additional { passed } else { 0 };
        } else {
            *self = Self { at: syncs, step: passed, ..Self::default() };
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The odd frames of a PDO that comes after these numbers of SYNC messages.
    fn odd(steps: impl IntoIterator<Item = u32>) -> Vec<(u32, u32)> {
        let (mut pace, mut syncs) = (Pace::default(), 0);
        let beats = steps.into_iter().filter_map(|step| {
            syncs += step;
            pace.beat(syncs, true)
        });
        beats.map(|odd| (odd.step, odd.passed)).collect()
    }

    #[test]
    fn a_frame_that_is_left_out_or_additional() {
        let steady = || std::iter::repeat_n(2, 40);
        assert_eq!(odd(steady().chain([4]).chain(steady())), [(2, 4)]);
        assert_eq!(odd(steady().chain([1, 1]).chain(steady())), [(2, 1)]);
        assert_eq!(odd(steady().chain([0, 2]).chain(steady())), [(2, 0)]);
        // Another step, and too few frames.
        assert_eq!(odd(steady().chain(std::iter::repeat_n(3, 40))), []);
        assert_eq!(odd([2, 2, 2, 4, 2, 2]), []);
    }
}
