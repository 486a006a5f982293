//! The cases, by standard.

mod cia301;
pub(crate) mod cia305;
mod cia306;
mod cia406;
pub(crate) mod ds205;
