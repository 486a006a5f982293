//! The rules of the analyzer on captures of the simulated devices: nothing is found where the device is well, and each
//! fault of a firmware that a capture can show is found.

// `cfg(test)` says nothing new here, but clippy tells by it where a test may unwrap.
#![cfg(test)]

mod faulty;
mod healthy;
mod machine;
