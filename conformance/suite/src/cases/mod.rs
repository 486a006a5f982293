//! The cases, by standard.

pub(crate) mod cia301;
pub(crate) mod cia305;
pub(crate) mod cia306;
pub(crate) mod ds205;
mod layer_setting;
