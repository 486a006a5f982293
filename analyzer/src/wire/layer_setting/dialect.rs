//! The differences between LSS and LMT.

use super::ConfigureCommand;
use crate::wire::{Field, Malformed};
use nom::IResult;
use std::fmt::{Debug, Display};
use std::hash::Hash;

/// The protocol of a message on 7E5h and 7E4h.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Protocol {
    /// Layer setting services, CiA 305.
    Lss,
    /// Layer management, CiA DS-205.
    Lmt,
}

impl Protocol {
    /// The only protocol that has the command specifier of a payload; `None` if both or neither have it.
    pub fn of(payload: &[u8]) -> Option<Self> {
        match payload.first()? {
            0x01..=0x03 | 0x05..=0x09 | 0x24..=0x26 => Some(Self::Lmt),
            0x40..=0x44 | 0x46..=0x4C | 0x4F..=0x51 | 0x5A..=0x5E => Some(Self::Lss),
            _ => None,
        }
    }
}

/// The differences between LSS and LMT.
pub trait Dialect: Copy + Eq + Hash + Debug + 'static {
    /// The parts of an address.
    type Part: Numbered;
    /// The bounds of "identify remote slave".
    type Bound: Numbered;
    /// The value of a part or a bound; numbers are ordered.
    type Value: Value;

    /// The protocol of this dialect.
    const PROTOCOL: Protocol;
    /// The parser's expected text for byte 0.
    const SPECIFIER: &'static str;
    /// The command specifier of the first part of "switch selective".
    const SWITCH_SELECTIVE: u8;
    /// The command specifier of the first bound of "identify remote slave".
    const IDENTIFY_REMOTE: u8;
    /// The command specifier of the answer to "identify remote slave".
    const IDENTIFIED: u8;
    /// The command specifier that inquires the first part of an address.
    const INQUIRE: u8;
    /// The fields of the answer to an inquiry of a part.
    const PART_FIELDS: &'static [Field];
    /// The standard's word for the state of a slave: state, or mode.
    const STATE: &'static str;
    /// The standard's name of the state other than configuration.
    const WAITING: &'static str;
    /// The standard's name of command 11h.
    const CONFIGURE_NODE_ID: &'static str;

    /// The part that a bound limits, and the side from which the bound limits this part.
    fn limits(bound: Self::Bound) -> (Self::Part, Limit);
    /// The bit rate of a row of table 0, in bit/s; `None` for a row that has none.
    fn bit_rate(index: u8) -> Option<u32>;
    /// The meaning of an error code that differs between the dialects; `None` for a reserved code.
    fn error_name(command: ConfigureCommand, error: u8) -> Option<&'static str>;
    /// The value of a part as text.
    fn words(part: Self::Part, value: Self::Value) -> impl Display;

    /// The row of table 0 with this bit rate, in bit/s.
    fn bit_rate_index(rate: u32) -> Option<u8> {
        (0..=u8::MAX).find(|&index| Self::bit_rate(index) == Some(rate))
    }
}

/// The kind of a bound.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Limit {
    /// The part equals the value.
    Equal,
    /// The part is at least the value.
    Lowest,
    /// The part is at most the value.
    Highest,
}

/// Parts or bounds with a fixed order and consecutive command specifiers.
pub trait Numbered: Copy + Eq + Hash + Debug + 'static {
    /// All of them, in order.
    const ALL: &'static [Self];

    /// The position in the order.
    fn position(self) -> usize;
    /// The standard's name.
    fn name(self) -> &'static str;

    /// Whether this part or bound is the last one.
    fn is_last(self) -> bool {
        self.position() + 1 == Self::ALL.len()
    }
}

/// The value of a part of an address.
pub trait Value: Copy + Ord + Hash + Debug + 'static {
    /// Reads the value from the bytes after the command specifier.
    ///
    /// # Errors
    /// [`Malformed`] if there are too few bytes.
    fn parse(input: &[u8]) -> IResult<&[u8], Self, Malformed>;
    /// Writes the value to the bytes after the command specifier.
    fn emit(self, tail: &mut [u8]);
}

/// Declares parts or bounds by their names in the standard, in order.
macro_rules! numbered {
    ($(#[$docs:meta])* $name:ident { $($(#[$variant_docs:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$docs])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
        pub enum $name {
            $($(#[$variant_docs])* $variant,)*
        }

        impl $name {
            /// All of them, in order.
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
