//! The tester's side of the protocols, as state machines without I/O and clock: the [`crate::bench`] drives them in
//! cases, [`Exchange`] in commands.

mod exchange;
pub mod lss;
pub mod sdo;

pub use exchange::Exchange;
pub use sdo::{Outcome, Step, Transfer, Violation};
