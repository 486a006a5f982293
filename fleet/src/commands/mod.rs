//! The subcommands, one file each.

pub mod ingest;
pub mod schema;
mod shell;
pub mod sql;
