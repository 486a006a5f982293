//! Simulated CANopen devices: their models, their behaviour, and the effects of a faulty firmware.
//!
//! - [`Device`]: a device without I/O and clock; [`Motion`]: the motion of the measured quantity; [`Memory`]: the
//!   stored values;
//! - [`models`]: the built-in models, and models made of a user's own description;
//! - [`Application`], [`Profile`]: the interface to device profiles; [`profiles`]: the built-in profiles;
//! - [`Fault`], [`Faults`]: defects of a firmware;
//! - [`Liberty`], [`Liberties`]: behaviour that the standard leaves free, and that differs between firmwares;
//! - [`Firmware`]: the faults and liberties of a device;
//! - [`address`]: the addresses of buses as a user types them, simulated devices among them.

#![warn(clippy::disallowed_methods)]
#![allow(missing_docs, reason = "an internal crate: where the name says it all, there is no comment")]

pub mod address;
mod damage;
mod device;
mod fault;
mod firmware;
mod liberty;
pub mod models;
pub mod profiles;

pub use device::{
    Application, ApplicationError, ApplicationErrors, Device, Memory, MemoryError, Motion, MotionError, MotionSpec,
    Parameters, Profile, Registered, Surroundings,
};
pub use fault::{Fault, Faults, UnknownFault};
pub use firmware::Firmware;
pub use liberty::{Liberties, Liberty, UnknownLiberty};
