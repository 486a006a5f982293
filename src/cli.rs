//! The command line.

use crate::commands;
use crate::output::Color;
use crate::status::{Failure, Status};
use clap::{Parser, Subcommand};

/// CANopen trace analyzer and protocol conformance tester.
#[derive(Parser)]
#[command(name = "canvass", version, propagate_version = true, max_term_width = 100)]
#[command(after_help = "\
Exit status: 0 good; 1 findings, failures or a property broken; 2 wrong usage or unreadable input;
3 bus or device could not be reached, or no case ran.")]
pub struct Cli {
    /// Colours: on a terminal, always or never
    #[arg(long, global = true, value_enum, default_value_t, value_name = "WHEN")]
    color: Color,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Decode(commands::decode::Args),
    Diagnose(commands::diagnose::Args),
    Signals(commands::signals::Args),
    Convert(commands::convert::Args),
    Test(commands::test::Args),
    Fuzz(commands::fuzz::Args),
    Simulate(commands::simulate::Args),
    Monitor(commands::monitor::Args),
    Record(commands::record::Args),
    Scan(commands::scan::Args),
    Selftest(commands::selftest::Args),
    Compare(commands::compare::Args),
    Send(commands::send::Args),
    Sdo(commands::sdo::Args),
    Nmt(commands::nmt::Args),
    Lss(commands::lss::Args),
    Doctor(commands::doctor::Args),
    List(commands::list::Args),
    Explain(commands::explain::Args),
    Completions(commands::completions::Args),
    Man(commands::man::Args),
}

impl Cli {
    /// Does what was asked for.
    pub fn run(self) -> Result<Status, Failure> {
        match self.command {
            Command::Decode(args) => args.run(self.color),
            Command::Diagnose(args) => args.run(self.color),
            Command::Signals(args) => args.run(),
            Command::Test(args) => args.run(self.color),
            Command::Fuzz(args) => args.run(),
            Command::Simulate(args) => args.run(),
            Command::Monitor(args) => args.run(self.color),
            Command::Record(args) => args.run(),
            Command::Scan(args) => args.run(),
            Command::Selftest(args) => args.run(),
            Command::Compare(args) => args.run(),
            Command::Send(args) => args.run(self.color),
            Command::Sdo(args) => args.run(),
            Command::Nmt(args) => args.run(self.color),
            Command::Lss(args) => args.run(),
            Command::Doctor(args) => args.run(),
            Command::Convert(args) => args.run(),
            Command::Completions(args) => args.run(),
            Command::Man(args) => args.run(),
            Command::List(args) => args.run(),
            Command::Explain(args) => args.run(),
        }
    }
}
