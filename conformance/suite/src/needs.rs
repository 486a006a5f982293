//! All needs, each beside the cases that use it. `needs = [VisibleState]` of the `#[case]` attribute names
//! [`VISIBLE_STATE`].

pub use crate::cases::cia301::needs::*;
pub use crate::cases::cia305::needs::*;
pub use crate::cases::cia306::needs::*;
pub use crate::cases::cia406::needs::*;
pub use crate::cases::ds205::needs::*;
