//! Captures and results: found by patterns, opened on disk or in an object store, read one after the other.

mod access;
mod object;
mod pattern;
mod reading;

pub use access::{Access, AccessError, locate};
pub use pattern::{PatternError, find};
pub use reading::{Reading, Seen, Unreadable};

use serde::{Deserialize, Serialize};

/// A file that may be a capture or a result: plain data, which travel with a plan.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
pub struct CaptureFile {
    /// Its path as it was asked for, or its URL, such as `s3://bucket/field/a.log`.
    pub name: String,
    /// Its length in bytes.
    pub size: u64,
    /// When it was last written, in nanoseconds since 1970; 0 where that is not known.
    pub modified: i64,
}

/// Whether a name is a URL of an object store, and no path.
pub fn is_url(name: &str) -> bool {
    name.split_once("://").is_some_and(|(scheme, _)| scheme.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}
