//! The conformance suite: the cases, the bench on which they run, and the runner.
//!
//! - [`catalogue`]: all cases; [`case`](mod@case): the parts of a case; [`verdict`]: the outcomes of a case;
//! - [`foreign`]: effects of other nodes on the bus;
//! - [`need`]: the features of a device that a case needs; [`needs`]: all needs;
//! - [`bench`](mod@bench): the connection of a case to the device;
//! - [`runner`]: runs cases and reports events; [`waiver`]: the failures that the user accepts;
//! - [`selftest`]: the cases tested on firmware with known faults.

#![warn(clippy::disallowed_methods)]

pub mod behaviour;
pub mod bench;
pub mod case;
mod cases;
pub mod catalogue;
pub use canvass_analyzer::clause;
pub mod comparison;
mod covering;
pub mod dice;
pub mod foreign;
pub mod glob;
pub mod identity;
pub mod journal;
pub mod need;
pub mod needs;
pub mod order;
mod profiles;
pub mod quarantine;
pub mod runner;
#[cfg(test)]
#[path = "../tests/scripted/mod.rs"]
mod scripted;
pub mod selftest;
pub mod situation;
pub mod touch;
mod trial;
pub mod verdict;
pub mod waiver;
pub mod zero_point;

// Code written by `#[case]` names this crate, so that the cases of a profile can be in another crate; so do tests that
// the crate shares with its folder `tests`.
extern crate self as canvass_suite;

pub use canvass_device::Fault;
use canvass_macros::case;
