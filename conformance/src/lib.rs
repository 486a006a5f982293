//! CANopen conformance: buses, simulated devices, the case catalogue and the runner.

pub mod bus;
pub mod device;
mod fault;
mod machine;
pub mod models;

pub use fault::{Fault, Faults, UnknownFault};
pub use machine::Machine;
