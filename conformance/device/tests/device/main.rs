//! The simulated devices on the simulated bus.

// `cfg(test)` says nothing new here, but clippy tells by it where a test may unwrap.
#![cfg(test)]

mod allocations;
mod encoder;
mod errors;
mod nmt;
mod pdo;
mod quirks;
mod reference;
mod repeatable;
mod replay;
mod rig;
mod robustness;
mod sdo;
mod services;
mod tables;
mod timing;
