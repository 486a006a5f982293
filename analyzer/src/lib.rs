//! CANopen: from frames to messages, events and findings.
//!
//! - [`wire`]: one frame understood alone, one file per service, each with its parser and its encoder.
//! - [`dictionary`]: data types, values, device descriptions and the standard's object names.

pub mod dictionary;
mod identity;
pub mod wire;

pub use identity::{CobId, Index, Multiplexer, NodeId, SubIndex};
