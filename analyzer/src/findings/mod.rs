//! What was wrong on the buses of a capture.
//!
//! - [`Rule`] is one thing that can be wrong, one file each; its [`Metadata`] is what `canvass explain` and
//!   the reference page of rules say of it.
//! - [`Diagnosis`] takes a capture record by record, once, and lets every rule look at the frames of the services
//!   that it asks for.
//! - [`Finding`] is what a rule found. The same fault of the same node is one finding, however often it happens, so
//!   that memory does not grow with the capture.

mod bus;
mod capture;
mod context;
mod diagnosis;
mod dispatch;
mod effect;
mod emcy;
mod facts;
mod finding;
mod latest;
mod lss;
mod nodes;
mod order;
mod pdo;
mod percent;
mod provoked;
mod registry;
mod rhythm;
mod rule;
mod sdo;
mod seen;
mod sink;
mod source;
mod stories;
mod thresholds;
mod watch;
mod wear;

pub use context::{Context, Scene};
pub use diagnosis::{Diagnosis, Observed, Results};
pub use effect::{Effect, Rank};
pub(crate) use effect::{SETTLE, SOON};
pub(crate) use facts::Operand;
pub use facts::{Facts, NodeFacts};
pub use finding::{Exhibit, Finding, Severity};
pub use latest::Latest;
pub use order::{Disorder, InOrder};
pub use percent::Percent;
pub use registry::{all, find};
pub use rule::{Also, CaptureRule, Definition, Make, Metadata, Rule};
pub use seen::{Evidence, Seen};
pub use sink::{Report, Reported, Sink};
pub use source::SourceQuality;
pub use stories::{Consequence, Story};
pub use thresholds::{Threshold, ThresholdError, Thresholds, Unit};
