//! Rules about LSS and LMT.

mod dialogue;
mod exchange;
mod not_stored;
mod refused;
mod store_wear;
mod unanswered;

use super::rule::Definition;

pub static RULES: &[Definition] =
    &[unanswered::RULE, refused::RULE, dialogue::RULE, not_stored::RULE, store_wear::RULE];
