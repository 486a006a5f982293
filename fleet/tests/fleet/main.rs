//! All integration tests as one program: each separate program would link the query engine again.
#![cfg(test)]

mod answers;
mod cluster;
mod docs;
mod export;
mod lake;
mod sequences;
mod sink;
