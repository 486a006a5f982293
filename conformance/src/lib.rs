//! CANopen conformance: buses, simulated devices, the case catalogue and the runner.

pub mod bus;
mod fault;
mod machine;

pub use fault::Fault;
pub use machine::Machine;
