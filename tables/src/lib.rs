//! Captures as Arrow tables: each table's columns are defined once, for SQL, data frames and the documentation.
//!
//! - [`mod@column`]: columns: name, type, meaning, and the function that gets the value of a row;
//! - [`builder`]: batches of rows;
//! - [`decoded_frame`]: a frame with its meaning;
//! - [`frames`]: frames as they were recorded;
//! - [`messages`]: frames with their decoded meaning;
//! - [`events`]: whole SDO transfers, states, errors, layer setting; [`event_collector`] collects them;
//! - [`signals`]: the values of process data.

#![warn(clippy::disallowed_methods)]

pub mod builder;
pub mod column;
pub mod decoded_frame;
pub mod event_collector;
pub mod events;
pub mod frames;
pub mod messages;
pub mod signals;
