//! The simulated device profiles, one folder each.
//!
//! A profile registers its application with [`crate::Registered`], and its reader of sheets and descriptions with
//! [`crate::models::RegisteredSheet`]. The rest of the crate uses these lists and names no profile.

pub mod cia406;
