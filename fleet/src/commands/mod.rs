//! The subcommands, one file each.

pub mod executor;
pub mod export;
pub mod ingest;
pub mod report;
pub mod scheduler;
pub mod schema;
pub mod server;
mod shell;
pub mod sql;
