//! canvass: CANopen trace analyzer and protocol conformance tester.

#![warn(clippy::disallowed_methods)]

mod bundle;
mod cli;
mod commands;
mod damages;
mod destination;
mod devices;
mod files;
mod identity;
mod inputs;
mod interrupt;
mod kept_device;
mod live;
mod live_reader;
mod live_source;
mod output;
mod provenance;
mod put_back;
mod quality;
mod selection;
mod status;
mod time_range;
mod whole_file;

use status::Status;

fn main() -> std::process::ExitCode {
    let (cli, typed) = cli::Cli::of_arguments(quality::with_format(std::env::args_os()));
    let status = cli.run(&typed).unwrap_or_else(|failure| failure.report());
    // The process ends here: what is buffered was written by the commands themselves.
    Status::into(status)
}
