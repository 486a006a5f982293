//! Rules about EMCY.

mod contradiction;
mod never_cleared;
mod raised;
mod storm;

use super::rule::Definition;

pub static RULES: &[Definition] = &[raised::RULE, never_cleared::RULE, storm::RULE, contradiction::RULE];
