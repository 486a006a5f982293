//! All frames of the captures, small enough to be held, and any part of them with its meaning at once.
//!
//! - [`pack`]: a record in few bytes;
//! - [`store`]: blocks of them, and the state of the network at some;
//! - [`selection`]: the rows that pass a filter;
//! - [`overview`]: how many there were over time;
//! - [`rows`]: rows as the page shows them.

pub mod details;
pub mod overview;
pub mod pack;
pub mod rows;
pub mod selection;
pub mod store;
