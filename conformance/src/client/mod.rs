//! The tester's side of the protocols, as state machines without I/O and clock: the [`crate::bench`] drives them.

pub mod sdo;

pub use sdo::{Outcome, Step, Transfer, Violation};
