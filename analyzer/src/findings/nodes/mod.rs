//! Rules about nodes: their NMT states, boot-ups and error control.

mod boot_up_without_command;
mod command_not_obeyed;
mod consumer_time;
mod guarding_toggle;
mod guarding_unanswered;
mod heartbeat;
mod heartbeat_ended;
mod heartbeat_jitter;
mod heartbeat_late;
mod heartbeat_missing;
mod life_guarding;
mod no_boot_up;
mod pdo_outside_operational;
mod repeated_resets;
mod sdo_in_stopped;
mod state_lost;

pub use heartbeat::Heartbeats;

use super::rule::Definition;

pub static RULES: &[Definition] = &[
    boot_up_without_command::RULE,
    repeated_resets::RULE,
    no_boot_up::RULE,
    command_not_obeyed::RULE,
    state_lost::RULE,
    heartbeat_late::RULE,
    heartbeat_missing::RULE,
    heartbeat_ended::RULE,
    heartbeat_jitter::RULE,
    consumer_time::RULE,
    guarding_unanswered::RULE,
    guarding_toggle::RULE,
    life_guarding::RULE,
    pdo_outside_operational::RULE,
    sdo_in_stopped::RULE,
];
