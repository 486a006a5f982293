//! The message numbers of PEAK TRC: rows are numbered consecutively, so a missing row leaves a gap.
//!
//! If the numbers jump, the next row decides: numbering continues from the new number if rows are missing, and from the
//! old number if only one number is damaged.

use crate::{Damage, DamageKind, Place};

#[derive(Default)]
pub(crate) struct Numbers {
    /// The number that the next row should have; `None` before the first row of a recording.
    expected: Option<u64>,
    jump: Option<Jump>,
    owed: Option<Damage>,
}

/// A row with an unexpected number.
struct Jump {
    expected: u64,
    found: u64,
    place: Place,
}

impl Numbers {
    /// Begins a recording, which may begin with any number.
    pub(crate) fn restart(&mut self) {
        self.settle();
        self.expected = None;
    }

    /// Counts a row with an unreadable number.
    pub(crate) fn pass(&mut self) {
        self.settle();
        self.expected = self.expected.map(|number| number.saturating_add(1));
    }

    /// Checks the next row's number.
    #[inline]
    pub(crate) fn see(&mut self, number: u64, place: Place) {
        if self.expected != Some(number) || self.jump.is_some() {
            self.compare(number, place);
        }
        self.expected = Some(number.saturating_add(1));
    }

    fn compare(&mut self, number: u64, place: Place) {
        match self.jump.take() {
            Some(jump) if number == jump.expected.saturating_add(1) => self.owed = Some(jump.damaged_number()),
            jump => {
                self.owed = jump.map(Jump::missing_rows);
                if let Some(expected) = self.expected.filter(|&expected| expected != number) {
                    self.jump = Some(Jump { expected, found: number, place });
                }
            }
        }
    }

    /// The damage that the rows so far have revealed.
    #[inline]
    pub(crate) fn owed(&mut self) -> Option<Damage> {
        // Nearly always there is no damage; then nothing is moved.
        if self.owed.is_some() { self.owed.take() } else { None }
    }

    /// The damage at the end of the file.
    pub(crate) fn end(&mut self) -> Option<Damage> {
        self.settle();
        self.owed()
    }

    fn settle(&mut self) {
        if let Some(jump) = self.jump.take() {
            self.owed = Some(jump.missing_rows());
        }
    }
}

impl Jump {
    fn damaged_number(self) -> Damage {
        let expected = format!("the message number {}", self.expected);
        Damage::new(DamageKind::Malformed, self.place, expected, self.found.to_string().as_bytes())
    }

    /// The damage for missing or reordered rows.
    fn missing_rows(self) -> Damage {
        match self.found.checked_sub(self.expected) {
            Some(missing) => {
                let expected = format!("the message number {}", self.expected);
                Damage::new(DamageKind::Dropped(missing), self.place, expected, self.found.to_string().as_bytes())
            }
            None => self.damaged_number(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn damages(numbers: &[Option<u64>]) -> Vec<String> {
        let mut seen = Numbers::default();
        let mut damages = Vec::new();
        for (place, number) in (0..).zip(numbers) {
            match number {
                Some(number) => seen.see(*number, Place { number: place, offset: 0 }),
                None => seen.pass(),
            }
            damages.extend(seen.owed());
        }
        damages.extend(seen.end());
        damages.iter().map(|damage| format!("{}: {damage}", damage.place.number)).collect()
    }

    #[test]
    fn a_gap_tells_how_many_rows_are_missing() {
        assert_eq!(damages(&[Some(7), Some(8), None, Some(10)]), [""; 0]);
        let gap = "1: the recorder lost 3 frames here: expected the message number 8, found \"11\"";
        assert_eq!(damages(&[Some(7), Some(11), Some(12)]), [gap]);
        assert_eq!(damages(&[Some(7), Some(11)]), [gap]);
        assert_eq!(damages(&[Some(7), Some(11), None, Some(13)]), [gap]);
    }

    #[test]
    fn a_damaged_number_is_no_gap() {
        let damaged = "1: malformed: expected the message number 8, found \"98\"";
        assert_eq!(damages(&[Some(7), Some(98), Some(9), Some(10)]), [damaged]);
        let back = "1: malformed: expected the message number 8, found \"3\"";
        assert_eq!(damages(&[Some(7), Some(3), Some(4)]), [back]);
        assert_eq!(damages(&[Some(u64::MAX), Some(u64::MAX)]).len(), 0);
    }

    #[test]
    fn each_jump_is_told() {
        assert_eq!(damages(&[Some(1), Some(4), Some(9), Some(10)]).len(), 2);
    }
}
