//! Each liberty changes the behaviour of the device in exactly its own way.

// All code here is test code; the attribute tells clippy that it may unwrap.
#![cfg(test)]

mod descriptions;
mod shown;
mod steps;
