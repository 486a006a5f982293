//! Rules about LSS and LMT.

mod dialogue;
mod exchange;
mod left_in_configuration;
mod not_stored;
mod refused;
mod store_wear;
mod unanswered;
