//! The behaviour of the simulated devices on the simulated bus.

// All code here is test code; the attribute tells clippy that it may unwrap.
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
