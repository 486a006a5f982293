//! The device profiles whose devices are simulated, a folder each.
//!
//! A profile registers its application with [`crate::Registered`] and what it reads of sheets and descriptions with
//! [`crate::models::RegisteredSheet`]; the rest of the crate asks these lists and names no profile.

pub mod cia406;
