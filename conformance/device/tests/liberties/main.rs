//! Each liberty shows: the device behaves otherwise than without it, in exactly that way.

// `cfg(test)` says nothing new here, but clippy tells by it where a test may unwrap.
#![cfg(test)]

mod descriptions;
mod shown;
mod steps;
