//! Captures and results: found by patterns, opened on disk or in an object store, read one after the other.

mod access;
mod object;
mod pattern;
mod reading;

pub use access::{Access, AccessError, locate};
pub use pattern::{PatternError, find};
pub use reading::{Reading, Seen, Unreadable};

use serde::{Deserialize, Serialize};

/// A file that may be a capture or a result. The type is plain data, so that it can be sent with a plan.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Debug, Serialize, Deserialize)]
pub struct CaptureFile {
    /// The path as the user gave it, or the URL, such as `s3://bucket/field/a.log`. In a lake the absolute path, with
    /// the site before it if one is named: `bench-7:/data/a.log`.
    pub name: String,
    /// The path of the file, if the name is not the path.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path: Option<String>,
    /// The length of the file in bytes.
    pub size: u64,
    /// The time of the last write in nanoseconds since 1970; 0 if unknown.
    pub modified: i64,
}

impl CaptureFile {
    /// The site with its colon, if the name in the lake begins with one.
    pub fn site(&self) -> Option<&str> {
        self.path.as_deref().and_then(|path| self.name.strip_suffix(path))
    }

    /// The path or URL at which the file is opened.
    pub fn place(&self) -> &str {
        self.path.as_deref().unwrap_or(&self.name)
    }
}

/// Whether a name is the URL of an object store instead of a path.
pub fn is_url(name: &str) -> bool {
    name.split_once("://").is_some_and(|(scheme, _)| scheme.bytes().all(|byte| byte.is_ascii_alphanumeric()))
}
