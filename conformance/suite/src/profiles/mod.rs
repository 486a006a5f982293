//! The device profiles whose devices are tested, a folder each: cases, what they need, and what the bench must know.
//!
//! A profile registers itself with [`crate::bench::Registered`], its cases by `#[case]`; the rest of the crate names none.

mod cia406;
