//! `canvass-fleet`: SQL over captures and results, on one machine or a cluster.

#![warn(clippy::disallowed_methods)]

mod cli;
mod commands;
mod output;
mod status;

use clap::Parser as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = cli::Cli::parse();
    let runtime = match tokio::runtime::Builder::new_multi_thread().enable_all().build() {
        Ok(runtime) => runtime,
        Err(error) => return status::Failure::from(error).report().into(),
    };
    let ended = runtime.block_on(cli.run());
    let status = ended.unwrap_or_else(|failure| failure.report());
    // The process does not wait for captures still being read: nobody needs their rows any more.
    runtime.shutdown_background();
    status.into()
}
