//! The same tables and statements over several computers: Ballista's scheduler and executors, which know our tables.
//!
//! - [`codec`]: our tables and plans as bytes, on their way between computers;
//! - [`client`]: a session whose queries run on a cluster;
//! - [`scheduler`] and [`executor`]: Ballista's own processes.

pub mod client;
pub mod codec;
pub mod executor;
pub mod scheduler;

use crate::session::Settings;
use ballista_core::extension::SessionConfigExt as _;
use codec::{LogicalCodec, PhysicalCodec};
use datafusion::prelude::SessionConfig;
use std::sync::Arc;

/// Maximum length of a message between the processes in bytes; a plan names all its files.
pub const LONGEST_MESSAGE: u32 = 256 << 20;

/// Why a part of a cluster fails.
#[derive(Debug, thiserror::Error)]
pub enum ClusterError {
    /// The syntax of an address is wrong.
    #[error("\"{0}\" is no address of a scheduler: expected df://HOST:PORT, such as df://localhost:50050")]
    Address(String),
    /// No scheduler answers at the address.
    #[error("no scheduler answers at {address}: {reason}; `canvass-fleet scheduler --bind {address}` starts one")]
    Unreachable {
        /// The address.
        address: String,
        /// The reason.
        reason: String,
    },
    /// A port can't be opened.
    #[error("can't listen on {address}: {source}")]
    Bind {
        /// The address.
        address: String,
        /// The reason.
        source: std::io::Error,
    },
    /// The process ended on its own.
    #[error("the {process} stopped: {reason}")]
    Stopped {
        /// The name of the process.
        process: &'static str,
        /// The reason.
        reason: String,
    },
    /// The query engine can't be set up.
    #[error(transparent)]
    Engine(#[from] datafusion::error::DataFusionError),
    /// A folder can't be made.
    #[error("can't create a folder for the results of tasks: {0}")]
    Folder(#[source] std::io::Error),
}

/// The settings of all processes of a cluster.
fn config(settings: &Settings) -> SessionConfig {
    settings
        .config()
        .upgrade_for_ballista()
        // The adaptive planner of Ballista 55 plans some joins anew without end.
        .with_ballista_adaptive_query_planner(false)
        .with_ballista_logical_extension_codec(Arc::new(LogicalCodec::default()))
        .with_ballista_physical_extension_codec(Arc::new(PhysicalCodec::default()))
        .with_ballista_grpc_client_max_message_size(LONGEST_MESSAGE as usize)
}
