//! The diagnosis of a capture's buses.
//!
//! - A [`Rule`] finds one kind of problem; each rule has its own file. Its [`Metadata`] is the text of
//!   `canvass explain` and of the reference page.
//! - [`Diagnosis`] takes a capture record by record, once, and shows every rule the frames of the services that it asks
//!   for.
//! - A [`Finding`] is a problem that a rule found. All occurrences of one fault of one node are one finding, so that
//!   memory does not grow with the capture.

mod bus;
mod capture;
mod chosen;
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
mod occurrences;
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
mod srdo;
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
pub use occurrences::Occurrences;
pub use order::{Disorder, InOrder};
pub use percent::Percent;
pub use registry::{all, find};
pub use rule::{Also, CaptureRule, Definition, Make, Metadata, Rule};
pub use seen::{Evidence, Seen};
pub use sink::{Report, Reported, Sink};
pub use source::SourceQuality;
pub use stories::{Consequence, Story};
pub use thresholds::{Threshold, ThresholdError, Thresholds, Unit};
