//! canvass: CANopen trace analyzer and protocol conformance tester.

mod cli;
mod commands;
mod damages;
mod destination;
mod devices;
mod inputs;
mod interrupt;
mod kept_device;
mod live;
mod live_reader;
mod output;
mod quality;
mod selection;
mod status;
mod stdin;
mod time_range;

use clap::Parser;
use status::Status;

fn main() -> std::process::ExitCode {
    let cli = cli::Cli::parse_from(quality::with_format(std::env::args_os()));
    let status = cli.run().unwrap_or_else(|failure| failure.report());
    // The process ends here: what is buffered was written by the commands themselves.
    Status::into(status)
}
