//! Whole runs, and single cases, on devices of a few lines.

// `cfg(test)` says nothing new here, but clippy tells by it where a test may unwrap.
#![cfg(test)]

mod counts;
mod left_behind;
mod outcomes;
#[path = "../scripted/mod.rs"]
mod scripted;
