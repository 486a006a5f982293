//! CANopen: from frames to messages, events and findings.
//!
//! - [`wire`]: single frames without context, one file per service, each with its parser and its encoder.
//! - [`dictionary`]: data types, values, device descriptions and the standard's object names.
//! - [`filter`]: a small language for selecting frames.
//! - [`network`]: the state of a bus: COB-IDs in use, node states, whole transfers.
//! - [`findings`]: problems found by rules, one file for each rule.
//! - [`profiles`]: support of device profiles, one folder for each profile.
//! - [`statistics`]: figures of a bus and its nodes.

#![warn(clippy::disallowed_methods)]

mod case_mark;
pub mod clause;
pub mod dictionary;
pub mod filter;
pub mod findings;
mod identity;
pub mod message;
pub mod network;
mod node_range;
pub mod object;
mod per_node;
pub mod profiles;
mod room;
mod spelling;
pub mod statistics;
mod text;
pub mod wire;

pub use case_mark::CaseMark;
pub use identity::{CobId, Index, Multiplexer, NodeId, SubIndex};
pub use message::{Message, PdoNumber, Service};
pub use node_range::{NodeError, NodeRange};
pub use per_node::PerNode;
pub use spelling::{closest, meant};
pub use text::{EmcyText, Meaning, Name, Number, SignalValue, TransferText};
