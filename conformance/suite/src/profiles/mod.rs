//! The device profiles of the suite, each in its folder: cases, their needs, and the objects that the bench needs.
//!
//! A profile registers itself with [`crate::bench::Registered`], its cases by `#[case]`; the rest of the crate names no
//! profile.

mod cia406;
