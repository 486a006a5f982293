//! SYNC: the clock of synchronous PDOs (CAN-ID 080h unless 1005h says otherwise).
//!
//! ```text
//! no byte, or byte 0: counter 1..240 where 1019h is not 0
//! ```

use super::{Field, Fields, Layout, Malformed, Wire};
use nom::{IResult, Parser, combinator::opt, number::complete::u8};
use std::fmt;

/// The default CAN-ID.
pub const CAN_ID: u16 = 0x080;

/// A SYNC message.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Sync {
    /// The counter, if the producer counts. 1 to 240 is legal.
    pub counter: Option<u8>,
}

impl Wire for Sync {
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed> {
        opt(u8).map(|counter| Self { counter }).parse(input)
    }

    fn emit(&self, buffer: &mut [u8; 8]) -> usize {
        match self.counter {
            Some(counter) => {
                buffer[0] = counter;
                1
            }
            None => 0,
        }
    }
}

static SYNC: Layout = Layout { name: "SYNC", fields: &[Field::new("counter", 0, 0, 8)] };

impl Fields for Sync {
    const LAYOUTS: &'static [&'static Layout] = &[&SYNC];

    fn layout(&self) -> &'static Layout {
        &SYNC
    }
}

impl fmt::Display for Sync {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.counter {
            Some(counter @ 1..=240) => write!(f, "SYNC, counter {counter}"),
            Some(counter) => write!(f, "SYNC, counter {counter} (outside 1..240)"),
            None => f.write_str("SYNC"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::vectors::both_ways;
    use super::*;

    #[test]
    fn with_and_without_counter() {
        both_ways(&[], Sync { counter: None });
        both_ways(&[240], Sync { counter: Some(240) });
        assert_eq!(Sync { counter: Some(0) }.to_string(), "SYNC, counter 0 (outside 1..240)");
    }
}
