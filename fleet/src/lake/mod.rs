//! A lake: captures and results as Parquet, by table and date, with a log of its files.

mod entry;
mod ingest;
mod leftovers;
mod location;
mod log;
mod one_file;
mod parquet;
mod plan;
mod provider;

pub use entry::{Entry, Part, Span, day, part_name, rules};
pub use ingest::{Ingest, Progress, Summary};
pub use location::Location;
pub use log::Snapshot;
pub use plan::{IngestScan, IngestSpec, IngestTable};
pub use provider::{LakeSpec, LakeTable, register};

use datafusion::error::DataFusionError;

/// Why a lake can't be read or written.
#[derive(Debug, thiserror::Error)]
pub enum LakeError {
    /// The location does not exist.
    #[error("{place} is no place for a lake: expected a folder or s3://BUCKET/PREFIX ({reason})")]
    Place {
        /// The location as the user gave it.
        place: String,
        /// The reason.
        reason: String,
    },
    /// The location holds no lake.
    #[error("there is no lake at {0}: `canvass-fleet ingest … --into {0}` makes one")]
    Missing(String),
    /// A commit is malformed.
    #[error("commit {version} of the lake can't be read: {reason}")]
    Log {
        /// The number of the commit.
        version: u64,
        /// The reason.
        reason: String,
    },
    /// Another run has committed to the lake.
    #[error("another process ingests into {0} at the same time: this run stops, and its committed data stay")]
    Conflict(String),
    /// Other runs change the lake while it is read.
    #[error("the lake at {0} changes too quickly to be read: try again")]
    Changing(String),
    /// A folder of the lake can't be read or written.
    #[error("can't remove old files in {folder}: {source}", folder = folder.display())]
    Folder {
        /// The folder.
        folder: std::path::PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The store gave an error.
    #[error("the lake's store: {0}")]
    Store(#[from] object_store::Error),
}

impl From<LakeError> for DataFusionError {
    fn from(error: LakeError) -> Self {
        Self::External(Box::new(error))
    }
}
