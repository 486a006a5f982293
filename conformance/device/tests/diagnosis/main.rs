//! The rules of the analyzer on captures of the simulated devices: a fault-free device causes no findings, and each
//! fault that a capture can show is found.

// All code here is test code; the attribute tells clippy that it may unwrap.
#![cfg(test)]

mod faulty;
mod healthy;
mod machine;
