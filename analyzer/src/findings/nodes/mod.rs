//! Rules about nodes: their NMT states, boot-ups and error control.

mod boot_unfinished;
mod boot_up_without_command;
mod command_not_obeyed;
mod consumer_time;
mod guarding_ended;
mod guarding_toggle;
mod guarding_unanswered;
mod heartbeat_additional;
mod heartbeat_ended;
mod heartbeat_jitter;
mod heartbeat_late;
mod heartbeat_missing;
mod left_stopped;
mod life_guarding;
mod lost;
mod no_boot_up;
mod pdo_outside_operational;
mod repeated_resets;
mod restart;
mod sdo_in_stopped;
mod starts_twice;
mod state_lost;
