//! Third-party CANopen stacks, as devices on the simulated bus.
//!
//! Simulated devices and cases come from the same hands and can share a mistake. These come from other hands: each is
//! used as its documentation tells an application to, with a device description of ours that says what its object
//! dictionary holds. What the cases and the fuzzer find in them is in `docs/peers.md`.

pub mod canopen_rs;
mod stack;
pub mod zencan;

pub use stack::{Death, Memorial, Stack, StackDevice};
