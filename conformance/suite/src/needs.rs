//! The needs that any device may meet, each next to the cases that use it; needs of a device profile are in the
//! folder of the profile. `needs = [VisibleState]` of the `#[case]` attribute names [`VISIBLE_STATE`].

pub use crate::cases::cia301::needs::*;
pub use crate::cases::cia305::needs::*;
pub use crate::cases::cia306::needs::*;
pub use crate::cases::ds205::needs::*;
