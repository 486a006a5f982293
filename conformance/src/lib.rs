//! CANopen conformance: buses, simulated devices, the case catalogue and the runner.
//!
//! - [`bus`]: the bus that a test runs on, live or simulated;
//! - [`catalogue`]: all cases; [`case`] says what one is, [`verdict`] how it ends;
//! - [`bench`](mod@bench): where a case runs; [`client`]: the tester's side of the protocols;
//! - [`runner`]: runs cases and reports events.

pub mod bench;
pub mod bus;
pub mod case;
mod cases;
pub mod catalogue;
pub mod client;
mod fault;
mod machine;
pub mod runner;
#[cfg(test)]
mod scripted;
pub mod verdict;

use canvass_conformance_macros::case;
pub use fault::Fault;
pub use machine::Machine;
