//! SDO transfers, joined from their frames.
//!
//! Each channel (a pair of CAN-IDs) has at most one transfer at a time. Transfers of different channels interleave
//! freely.

mod block;
mod channel;
mod transfer;
mod under_way;

pub use channel::{Channel, ChannelIndex, Step};
pub use transfer::{Direction, Mode, Outcome, Side, Transfer, Violation};
