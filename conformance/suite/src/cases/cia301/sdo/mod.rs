//! The SDO server.

mod access;
mod block_download;
mod block_upload;
pub(super) mod by_hand;
mod combinations;
mod command;
mod described;
mod expedited;
mod frames;
mod own_values;
mod pairs;
mod refusals;
mod segmented_download;
mod segmented_upload;
mod sequence;
mod server_parameter;
mod toggle;
mod transfers;
