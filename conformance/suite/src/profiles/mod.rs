//! The tested device profiles, a folder each: cases, their needs, and the objects that the bench needs.
//!
//! A profile registers itself with [`crate::bench::Registered`], its cases by `#[case]`; the rest of the crate names none.

mod cia406;
