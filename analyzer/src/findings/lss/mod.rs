//! Rules about LSS and LMT.

mod address_series;
mod dialogue;
mod exchange;
mod left_in_configuration;
mod not_in_configuration;
mod not_stored;
mod refused;
mod same_address;
mod series;
mod store_wear;
mod unanswered;
mod undefined_request;
