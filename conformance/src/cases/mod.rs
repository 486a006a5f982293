//! The cases, by standard.

mod cia301;
mod cia305;
mod cia406;
pub(crate) mod ds205;
