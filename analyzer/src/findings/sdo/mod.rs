//! Rules about SDO transfers.

mod aborted;
mod late;
mod pending;
mod protocol_violation;
mod retries;
mod store_wear;
mod unanswered;

pub use pending::{Requests, Step};
pub use store_wear::{Wear, WearLimits};

use super::rule::Definition;

pub static RULES: &[Definition] =
    &[unanswered::RULE, late::RULE, retries::RULE, aborted::RULE, protocol_violation::RULE, store_wear::RULE];
