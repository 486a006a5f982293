//! The tests of the whole, as one program: each by itself would link the engine once more.
#![cfg(test)]

mod answers;
mod cluster;
mod docs;
mod export;
mod lake;
mod sink;
