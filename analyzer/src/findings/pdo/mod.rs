//! Rules about PDOs, SYNC and TIME.

mod inhibit_time;
mod jitter;
mod length;
mod parameters;
mod period;
mod sync_counter;
mod sync_jitter;
mod sync_missing;
mod sync_pdo_missing;
mod sync_window;
mod time_jump;

pub use parameters::{AllParameters, Parameters, TPDOS};

use super::rule::Definition;

pub static RULES: &[Definition] = &[
    length::RULE,
    period::RULE,
    jitter::RULE,
    inhibit_time::RULE,
    sync_missing::RULE,
    sync_jitter::RULE,
    sync_counter::RULE,
    sync_pdo_missing::RULE,
    sync_window::RULE,
    time_jump::RULE,
];
