//! Rules about SDO transfers.

mod aborted;
mod impatient_client;
mod late;
mod protocol_violation;
mod retries;
mod store_wear;
mod too_early;
mod unanswered;
