//! CANopen conformance: buses, simulated devices, the case catalogue and the runner.
//!
//! - [`bus`]: the bus that a test runs on, live or simulated;
//! - [`device`], [`models`]: simulated devices, and which there are;
//! - [`catalogue`]: all cases; [`case`](mod@case) says what one is, [`verdict`] how it ends;
//! - [`bench`](mod@bench): where a case runs; [`client`]: the tester's side of the protocols;
//! - [`runner`]: runs cases and reports events.

pub mod bench;
pub mod bus;
pub mod case;
mod cases;
pub mod catalogue;
pub mod client;
pub mod device;
mod fault;
pub mod fuzz;
mod machine;
pub mod models;
pub mod runner;
#[cfg(test)]
mod scripted;
pub mod selftest;
pub mod verdict;
pub mod waiver;

use canvass_conformance_macros::case;
pub use fault::{Fault, Faults, UnknownFault};
pub use machine::Machine;
