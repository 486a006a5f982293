//! Whole runs and single cases on devices of a few lines.

// `cfg(test)` has no effect here, but tells clippy where a test may unwrap.
#![cfg(test)]

mod counts;
mod left_behind;
mod outcomes;
#[path = "../scripted/mod.rs"]
mod scripted;
