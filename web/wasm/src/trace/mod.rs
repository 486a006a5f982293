//! All frames of the captures in compact form, from which any part can be decoded at once.
//!
//! - [`pack`]: a record in few bytes;
//! - [`store`]: blocks of records, and snapshots of the network;
//! - [`selection`]: the rows that pass a filter;
//! - [`overview`]: the number of frames over time;
//! - [`rows`]: rows as the page shows them.

pub mod details;
pub mod overview;
pub mod pack;
pub mod rows;
pub mod selection;
pub mod store;
