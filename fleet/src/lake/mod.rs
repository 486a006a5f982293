//! A lake: captures and results as Parquet, by table and date, with a log of what belongs to it.

mod entry;
mod ingest;
mod leftovers;
mod location;
mod log;
mod one_file;
mod parquet;
mod plan;
mod provider;

pub use entry::{Entry, Part, day, part_name, rules};
pub use ingest::{Ingest, Progress, Summary};
pub use location::Location;
pub use log::Snapshot;
pub use plan::{IngestScan, IngestSpec, IngestTable};
pub use provider::{LakeSpec, LakeTable, register};

use datafusion::error::DataFusionError;

/// Why a lake can't be read or written.
#[derive(Debug, thiserror::Error)]
pub enum LakeError {
    /// There is no such place.
    #[error("{place} is no place for a lake: expected a folder or s3://BUCKET/PREFIX ({reason})")]
    Place {
        /// As it was given.
        place: String,
        /// The reason.
        reason: String,
    },
    /// There is no lake.
    #[error("there is no lake at {0}: `canvass-fleet ingest … --into {0}` makes one")]
    Missing(String),
    /// A commit can't be understood.
    #[error("commit {version} of the lake can't be read: {reason}")]
    Log {
        /// Its number.
        version: u64,
        /// The reason.
        reason: String,
    },
    /// Somebody else writes.
    #[error("somebody else ingests into {0} at the same time: this run stops, and what it has committed stays")]
    Conflict(String),
    /// Somebody else writes.
    #[error("the lake at {0} changes too quickly to be read: try again")]
    Changing(String),
    /// A folder of the lake can't be read or written.
    #[error("can't clear away in {folder}: {source}", folder = folder.display())]
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
