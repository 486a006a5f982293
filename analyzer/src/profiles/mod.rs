//! The known device profiles, one folder for each: names, units and bits of objects, scaling, rules for descriptions,
//! and findings.
//!
//! A profile registers itself with [`crate::dictionary::names::Registered`], its rules with the lists of rules; the rest of
//! the crate asks these lists and names no profile. A further profile is a folder here and a line below.

mod cia401;
pub mod cia402;
pub mod cia406;
mod cia410;
