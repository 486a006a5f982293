//! Third-party CANopen stacks, as devices on the simulated bus.
//!
//! The same people wrote the simulated devices and the cases, and may have made the same mistake in both. Other people
//! wrote these stacks: each is used by an application as its documentation requires, with a device description of ours
//! for its object dictionary. The findings of the cases and of the fuzzer are in `docs/peers.md`.

pub mod canopen_rs;
mod stack;
pub mod zencan;

pub use stack::{Death, Memorial, Stack, StackDevice};
