//! The needs of cases that every device may have, each beside the cases that use it; those of a device profile are the
//! profile's own. `needs = [VisibleState]` of the `#[case]` attribute names
//! [`VISIBLE_STATE`].

pub use crate::cases::cia301::needs::*;
pub use crate::cases::cia305::needs::*;
pub use crate::cases::cia306::needs::*;
pub use crate::cases::ds205::needs::*;
