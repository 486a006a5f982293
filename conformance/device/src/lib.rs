//! Simulated CANopen devices: which there are, what they do, and what a faulty firmware makes of them.
//!
//! - [`Device`]: a device without I/O and clock; [`Motion`]: the motion of the measured quantity; [`Memory`]: the
//!   stored values;
//! - [`models`]: the built-in models and those of a user's own description;
//! - [`Application`], [`Profile`]: the seam for device profiles; [`profiles`]: the built-in ones;
//! - [`Fault`], [`Faults`]: defects of its firmware;
//! - [`Liberty`], [`Liberties`]: what the standard leaves free, and firmwares do in their own ways;
//! - [`Firmware`]: both together;
//! - [`address`]: the addresses of buses as they are typed, simulated devices among them.

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
