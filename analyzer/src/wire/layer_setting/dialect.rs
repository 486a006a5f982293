//! What LSS and LMT each make of layer setting.

use super::ConfigureCommand;
use crate::wire::{Field, Malformed};
use nom::IResult;
use std::fmt::{Debug, Display};
use std::hash::Hash;

/// Which of the two protocols of 7E5h and 7E4h a message belongs to.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Protocol {
    /// Layer setting services, CiA 305.
    Lss,
    /// Layer management, CiA DS-205.
    Lmt,
}

impl Protocol {
    /// The protocol that alone knows the command specifier of a payload; `None` where both know it or neither.
    pub fn of(payload: &[u8]) -> Option<Self> {
        match payload.first()? {
            0x01..=0x03 | 0x05..=0x09 | 0x24..=0x26 => Some(Self::Lmt),
            0x40..=0x44 | 0x46..=0x4C | 0x4F..=0x51 | 0x5A..=0x5E => Some(Self::Lss),
            _ => None,
        }
    }
}

/// What differs between LSS and LMT.
pub trait Dialect: Copy + Eq + Hash + Debug + 'static {
    /// The parts of an address.
    type Part: Numbered;
    /// The bounds of "identify remote slave".
    type Bound: Numbered;
    /// What a part or a bound holds; numbers are in order.
    type Value: Value;

    /// Which of the two this is.
    const PROTOCOL: Protocol;
    /// What a parser expects in byte 0.
    const SPECIFIER: &'static str;
    /// The command specifier of the first part of "switch selective".
    const SWITCH_SELECTIVE: u8;
    /// The command specifier of the first bound of "identify remote slave".
    const IDENTIFY_REMOTE: u8;
    /// The command specifier of the answer to it.
    const IDENTIFIED: u8;
    /// The command specifier that inquires the first part of an address.
    const INQUIRE: u8;
    /// The fields of the answer to it.
    const PART_FIELDS: &'static [Field];
    /// What the standard calls what a slave is in: a state, or a mode.
    const STATE: &'static str;
    /// What it calls the one that is not configuration.
    const WAITING: &'static str;
    /// The standard's name of command 11h.
    const CONFIGURE_NODE_ID: &'static str;

    /// The part that a bound limits, and how.
    fn limits(bound: Self::Bound) -> (Self::Part, Limit);
    /// The bit rate of a row of table 0, in bit/s; `None` for a row that has none.
    fn bit_rate(index: u8) -> Option<u32>;
    /// What an error code means that does not mean the same in both dialects; `None` for a reserved one.
    fn error_name(command: ConfigureCommand, error: u8) -> Option<&'static str>;
    /// The value of a part in words.
    fn words(part: Self::Part, value: Self::Value) -> impl Display;

    /// The row of table 0 that has a bit rate, in bit/s.
    fn bit_rate_index(rate: u32) -> Option<u8> {
        (0..=u8::MAX).find(|&index| Self::bit_rate(index) == Some(rate))
    }
}

/// How a bound limits a part.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Limit {
    /// The part is that value.
    Equal,
    /// It is not less.
    Lowest,
    /// It is not more.
    Highest,
}

/// Parts or bounds, which have to come in their order, each with the command specifier after that of the one before.
pub trait Numbered: Copy + Eq + Hash + Debug + 'static {
    /// All of them, in their order.
    const ALL: &'static [Self];

    /// The position in their order.
    fn position(self) -> usize;
    /// The standard's name.
    fn name(self) -> &'static str;

    /// Whether it completes an address.
    fn is_last(self) -> bool {
        self.position() + 1 == Self::ALL.len()
    }
}

/// What a part of an address holds.
pub trait Value: Copy + Ord + Hash + Debug + 'static {
    /// Reads it from the bytes after the command specifier.
    ///
    /// # Errors
    /// [`Malformed`] if they are too few.
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed>;
    /// Writes it to the bytes after the command specifier.
    fn emit(self, tail: &mut [u8]);
}

/// Declares parts or bounds by their names in the standard, in their order.
macro_rules! numbered {
    ($(#[$docs:meta])* $name:ident { $($(#[$variant_docs:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$docs])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum $name {
            $($(#[$variant_docs])* $variant,)*
        }

        impl $name {
            /// All of them, in their order.
            pub const ALL: [Self; [$($text),*].len()] = [$(Self::$variant),*];

            /// The standard's name.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $text,)*
                }
            }
        }

        impl $crate::wire::layer_setting::Numbered for $name {
            const ALL: &'static [Self] = &Self::ALL;

            fn position(self) -> usize {
                self as usize
            }

            fn name(self) -> &'static str {
                self.name()
            }
        }
    };
}
pub(in crate::wire) use numbered;
