//! Random choices.

use proptest::prelude::Rng;
use proptest::test_runner::TestRng;

/// A source of random choices.
pub(crate) struct Dice<'a>(&'a mut TestRng);

impl<'a> Dice<'a> {
    pub fn new(rng: &'a mut TestRng) -> Self {
        Self(rng)
    }

    pub fn number(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// A random number from 0 to `n` - 1.
    pub fn below(&mut self, n: usize) -> usize {
        // The bias of a 64-bit number is negligible here.
        ((u128::from(self.number()) * n as u128) >> 64) as usize
    }

    pub(crate) fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn byte(&mut self) -> u8 {
        self.number() as u8
    }

    pub fn flip(&mut self) -> bool {
        self.number() & 1 != 0
    }

    /// A random item of the list; `None` if the list is empty.
    pub fn pick<'t, T>(&mut self, of: &'t [T]) -> Option<&'t T> {
        if of.is_empty() { None } else { of.get(self.below(of.len())) }
    }

    /// A random item of a fixed list.
    pub fn one_of<T: Copy, const N: usize>(&mut self, of: [T; N]) -> T {
        const { assert!(N > 0) };
        of[self.below(N)]
    }
}
