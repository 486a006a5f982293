//! Rules about LSS and LMT.

mod not_stored;
mod refused;
mod unanswered;

use super::rule::Definition;

pub static RULES: &[Definition] = &[unanswered::RULE, refused::RULE, not_stored::RULE];
