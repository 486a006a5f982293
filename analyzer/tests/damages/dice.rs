//! Random numbers that the same seed repeats.

/// The random numbers of SplitMix64.
pub struct Dice(pub u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// A number from `low` to `high`, both included.
    pub fn between(&mut self, low: u64, high: u64) -> u64 {
        low + self.next() % (high - low + 1)
    }

    /// A random index below `length`.
    pub fn below(&mut self, length: usize) -> usize {
        self.between(0, length as u64 - 1) as usize
    }

    /// A random `bool`.
    pub fn heads(&mut self) -> bool {
        self.next().is_multiple_of(2)
    }

    /// One of `all`; `None` if it is empty.
    pub fn pick<T: Clone>(&mut self, all: &[T]) -> Option<T> {
        if all.is_empty() { None } else { Some(all[self.below(all.len())].clone()) }
    }

    /// One of `all`, which is not empty.
    pub fn of<T: Clone>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())].clone()
    }

    /// A word of small letters that is no name of a section or field.
    pub fn word(&mut self) -> String {
        let length = self.between(5, 9);
        (0..length).map(|_| char::from(b'p' + self.below(10) as u8)).collect()
    }
}
