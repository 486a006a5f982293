//! The cases, by standard.

mod cia301;
