//! The conformance suite: the cases, what they run on, and who runs them.
//!
//! - [`catalogue`]: all cases; [`case`](mod@case) says what one is, [`verdict`] how it ends;
//! - [`foreign`]: what others on the bus may have caused;
//! - [`need`]: what a case needs of a device; [`needs`]: all needs;
//! - [`bench`](mod@bench): where a case runs;
//! - [`runner`]: runs cases and reports events; [`waiver`]: which failures the user accepts;
//! - [`selftest`]: the cases tested on firmware with known faults.

#![warn(clippy::disallowed_methods)]

pub mod behaviour;
pub mod bench;
pub mod case;
mod cases;
pub mod catalogue;
pub use canvass_analyzer::clause;
pub mod comparison;
pub mod foreign;
pub mod glob;
pub mod identity;
pub mod journal;
pub mod need;
pub mod needs;
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

// Code that `#[case]` writes names this crate, so that the cases of a profile can be in another one; so do tests that
// the crate shares with its folder `tests`.
extern crate self as canvass_suite;

pub use canvass_device::Fault;
use canvass_macros::case;
