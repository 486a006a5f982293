//! Simulated CANopen devices: which there are, what they do, and what a faulty firmware makes of them.
//!
//! - [`Device`]: a device without I/O and clock; [`Motion`]: how its shaft moves; [`Memory`]: what survives power-off;
//! - [`models`]: the built-in models and those of a user's own description;
//! - [`Fault`], [`Faults`]: defects of its firmware;
//! - [`address`]: the addresses of buses as they are typed, simulated devices among them.

pub mod address;
mod device;
mod fault;
mod firmware;
pub mod models;

pub use device::{Device, Memory, MemoryError, Motion, MotionError, MotionSpec};
pub use fault::{Fault, Faults, UnknownFault};
pub use firmware::Firmware;
