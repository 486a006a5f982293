//! canvass: CANopen trace analyzer and protocol conformance tester.

#![warn(clippy::disallowed_methods)]

mod allow;
mod bundle;
mod cli;
mod commands;
mod completion;
mod console;
mod damages;
mod destination;
mod devices;
mod files;
mod inputs;
mod interrupt;
mod kept_device;
mod live;
mod live_reader;
mod live_source;
mod output;
mod progress;
mod provenance;
mod put_back;
mod quality;
mod reconnect;
mod selection;
mod settings;
mod shown;
mod status;
mod time_range;
mod timing;
mod upload_limit;
mod whole_file;

use status::Status;

fn main() -> std::process::ExitCode {
    clap_complete::CompleteEnv::with_factory(cli::Cli::described).var(completion::VARIABLE).complete();
    let started = cli::Cli::of_arguments(quality::with_format(console::arguments().into_iter()).collect());
    let ended = started.and_then(|(cli, typed)| cli.run(&typed));
    let status = ended.unwrap_or_else(|failure| failure.report());
    // Commands have flushed their own buffers, so the process may end here.
    Status::into(status)
}
