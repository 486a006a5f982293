//! Captures as tables: from a pattern to batches of rows.

pub mod diagnosed;
pub mod emit;
pub mod files;
mod functions;
mod options;
mod plan;
mod produce;
mod provider;
pub mod results;
pub mod rows;

pub use functions::{FileTables, register, register_files};
pub use options::Options;
pub use plan::{CaptureScan, ScanSpec};
pub use produce::{Source, capture_row, produce, unreadable_row};
pub use provider::{CaptureTable, Files, partitions};

use crate::capture::{AccessError, PatternError};
use crate::devices::DeviceError;
use datafusion::arrow::error::ArrowError;
use datafusion::error::DataFusionError;

/// Why a scan failed.
#[derive(Debug, thiserror::Error)]
pub enum ScanError {
    /// A file can't be read.
    #[error(transparent)]
    Access(#[from] AccessError),
    /// No file matches a pattern.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// A device description can't be read.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// Arrow refuses a batch.
    #[error("a batch could not be created: {0}")]
    Arrow(#[from] ArrowError),
    /// The diagnosis can't write its temporary file.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl From<ScanError> for DataFusionError {
    fn from(error: ScanError) -> Self {
        Self::External(Box::new(error))
    }
}
