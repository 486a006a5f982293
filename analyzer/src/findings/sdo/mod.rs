//! Rules about SDO transfers.

mod aborted;
mod impatient_client;
mod late;
mod protocol_violation;
mod reserved_bits;
mod retries;
mod store_wear;
mod too_early;
mod unanswered;
mod unfinished;
