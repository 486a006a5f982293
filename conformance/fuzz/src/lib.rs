//! Property-based fuzzing of a device: sequences of frames, reference models that say what may come back, and
//! reproducers small enough to mail.
//!
//! ```text
//! generate -> sequence --execute--> bus <--> device
//!                          |
//!                     every frame --oracle--> violation --shrink--> reproducer
//! ```

#![warn(clippy::disallowed_methods)]

mod baseline;
pub mod campaign;
mod condense;
pub mod coverage;
pub mod detection;
mod execute;
mod generate;
mod knowledge;
mod learn;
pub mod liberties;
pub mod limits;
mod live;
mod oracle;
mod prelude;
pub mod profile;
mod profiles;
mod property;
pub mod reproducer;
mod shrink;
mod spent;
pub mod stand;
mod stimulus;
pub mod storm;
pub mod time_limit;
mod trust;

pub use baseline::{FinalState, Kept};
pub use generate::{Dialogues, Target, Targets, UnknownTarget};
pub use knowledge::{Knowledge, Known, Patience, Services};
pub use live::Live;
pub use oracle::{Defect, DeviceState, Symptom, Violation, WrongAnswer};
pub use property::{ProfileProperty, Property, UnknownProperty};
pub use shrink::SequenceTree;
pub use spent::{Cause, Spent};
pub use stimulus::{Sequence, Start, Stimulus, Then};
