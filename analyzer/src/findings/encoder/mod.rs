//! Rules about encoders (CiA 406). They look only at nodes whose device profile is known to be that: from 1000h in the
//! capture, or from a description.

mod alarm;
mod operands;
mod parameter_changed;
mod position_frozen;
mod position_jump;
mod position_outside_range;
mod redundant_channels;
mod warning;

pub use operands::{Operand, collect};

use super::rule::Definition;

pub static RULES: &[Definition] = &[
    alarm::RULE,
    warning::RULE,
    position_jump::RULE,
    position_frozen::RULE,
    position_outside_range::RULE,
    redundant_channels::RULE,
    parameter_changed::RULE,
];
