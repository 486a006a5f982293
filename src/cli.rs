//! The command line.

use crate::commands;
use crate::completion;
use crate::output::{Color, print};
use crate::provenance::Typed;
use crate::settings::{self, BUS_VARIABLE, Completed};
use crate::status::{Failure, Status};
use canvass_reports::escape::Printable;
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;

const STATUSES: &str = "\
Exit status: 0 good; 1 findings, failures or violations; 2 wrong usage or unreadable input;
3 bus or device could not be reached, or no case ran.";

/// CANopen trace analyzer and protocol conformance tester
///
/// Without a command it says what can be done with the files of this folder and the buses of this computer.
/// `canvass --version --verbose` tells how the program was built.
#[derive(Parser)]
#[command(name = "canvass", version, propagate_version = true, max_term_width = 100)]
#[command(disable_help_subcommand = true)]
#[command(after_help = STATUSES)]
pub struct Cli {
    /// Use colours on a terminal (auto), always or never
    #[arg(long, global = true, value_enum, default_value_t, value_name = "WHEN")]
    color: Color,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    Decode(commands::decode::Args),
    Diagnose(commands::diagnose::Args),
    Signals(commands::signals::Args),
    Plot(commands::plot::Args),
    Convert(commands::convert::Args),
    Test(commands::test::Args),
    Verify(commands::verify::Args),
    Restore(commands::restore::Args),
    Fuzz(commands::fuzz::Args),
    Simulate(commands::simulate::Args),
    Monitor(commands::monitor::Args),
    Record(commands::record::Args),
    Scan(commands::scan::Args),
    Selftest(commands::selftest::Args),
    Compare(commands::compare::Args),
    History(commands::history::Args),
    Waivers(commands::waivers::Args),
    Send(commands::send::Args),
    Sdo(commands::sdo::Args),
    Nmt(commands::nmt::Args),
    Lss(commands::lss::Args),
    Lmt(commands::lmt::Args),
    Eds(commands::eds::Args),
    Dcf(commands::dcf::Args),
    Lsp(commands::lsp::Args),
    Fleet(commands::fleet::Args),
    Doctor(commands::doctor::Args),
    Tour(commands::tour::Args),
    Examples(commands::examples::Args),
    Config(commands::config::Args),
    List(commands::list::Args),
    Explain(commands::explain::Args),
    Completions(commands::completions::Args),
    Man(commands::man::Args),
    Help(commands::help::Args),
}

impl Cli {
    /// The whole command line as clap knows it, with the texts about environment and exit status and the candidates of
    /// completion.
    pub fn described() -> clap::Command {
        let command = Self::command().color(crate::output::colors_of_help());
        completion::with_candidates(with_statuses(with_environment(command)))
    }

    /// Parses the command line, and notes the typed options for the provenance. Help and usage errors end the program.
    ///
    /// # Errors
    /// If the settings file can't be read or has an error.
    pub fn of_arguments(arguments: Vec<OsString>) -> Result<(Self, Typed), Failure> {
        if asks_for_build(&arguments) {
            print(&Printable::document(&build()))?;
            std::process::exit(Status::Good as i32);
        }
        let plain = Self::described();
        let Completed { mut command, arguments, set, file } = settings::complete(plain.clone(), arguments)?;
        let matches = command.try_get_matches_from_mut(arguments).unwrap_or_else(|mistake| told(mistake).exit());
        let typed = Typed::of(&plain, &matches, &set, file);
        let cli = Self::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit());
        Ok((cli, typed))
    }

    /// Runs the chosen subcommand.
    pub fn run(self, typed: &Typed) -> Result<Status, Failure> {
        let Some(command) = self.command else { return commands::welcome::run() };
        match command {
            Command::Decode(args) => args.run(self.color),
            Command::Diagnose(args) => args.run(self.color, typed),
            Command::Signals(args) => args.run(),
            Command::Plot(args) => args.run(),
            Command::Test(args) => args.run(self.color, typed),
            Command::Verify(args) => args.run(),
            Command::Restore(args) => args.run(),
            Command::Fuzz(args) => args.run(typed),
            Command::Simulate(args) => args.run(),
            Command::Monitor(args) => args.run(self.color),
            Command::Record(args) => args.run(),
            Command::Scan(args) => args.run(),
            Command::Selftest(args) => args.run(),
            Command::Compare(args) => args.run(typed),
            Command::History(args) => args.run(typed),
            Command::Waivers(args) => args.run(self.color),
            Command::Send(args) => args.run(self.color),
            Command::Sdo(args) => args.run(),
            Command::Nmt(args) => args.run(self.color),
            Command::Lss(args) => args.run(),
            Command::Lmt(args) => args.run(),
            Command::Eds(args) => args.run(self.color),
            Command::Dcf(args) => args.run(self.color),
            Command::Lsp(args) => args.run(),
            Command::Fleet(args) => args.run(),
            Command::Doctor(args) => args.run(),
            Command::Tour(args) => args.run(),
            Command::Examples(args) => args.run(),
            Command::Config(args) => args.run(),
            Command::Convert(args) => args.run(),
            Command::Completions(args) => args.run(),
            Command::Man(args) => args.run(Self::described()),
            Command::Help(args) => args.run(Self::described()),
            Command::List(args) => args.run(),
            Command::Explain(args) => args.run(),
        }
    }
}

/// Whether the arguments are `--version --verbose`, in any order.
fn asks_for_build(arguments: &[OsString]) -> bool {
    let words: Vec<_> = arguments.iter().skip(1).filter_map(|word| word.to_str()).collect();
    let has = |names: &[&str]| words.iter().any(|word| names.contains(word));
    words.len() == 2 && has(&["--version", "-V"]) && has(&["--verbose", "-v"])
}

/// How this program was built.
fn build() -> String {
    let features: &[&str] = if cfg!(feature = "screen") { &["screen"] } else { &[] };
    let libc = if cfg!(target_env = "musl") { "-musl" } else { "" };
    let optimised = if cfg!(debug_assertions) { "no (a development build)" } else { "yes" };
    format!(
        "canvass {}\ncommit     {}\ntarget     {}-{}{libc}\nfeatures   {}\noptimised  {optimised}\n",
        env!("CARGO_PKG_VERSION"),
        option_env!("CANVASS_COMMIT").unwrap_or("not recorded: `cargo xtask dist` records it"),
        std::env::consts::ARCH,
        std::env::consts::OS,
        if features.is_empty() { "none".to_owned() } else { features.join(", ") }
    )
}

/// Adds to an error about `--format parquet` or `arrow` that canvass-fleet writes these formats.
fn told(mut mistake: clap::Error) -> clap::Error {
    use clap::error::{ContextKind, ContextValue};
    let is = |kind, known: &[&str]| matches!(mistake.get(kind), Some(ContextValue::String(told)) if known.contains(&&**told));
    if is(ContextKind::InvalidArg, &["--format <FORMAT>"]) && is(ContextKind::InvalidValue, &["parquet", "arrow"]) {
        const TIP: &str = "canvass-fleet writes Parquet and Arrow: canvass fleet decode FILE --format parquet \
         --output FILE.parquet; its commands signals and diagnose take the same options";
        mistake.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![TIP.into()]));
    }
    mistake
}

/// Lets the environment name the bus. clap does it for commands that have no other positional argument; for the others
/// [`settings::complete`] does it, and their help says so.
fn with_environment(command: clap::Command) -> clap::Command {
    let is_bus = |argument: &clap::Arg| argument.get_id() == "bus";
    let with_variable = |argument: clap::Arg| match is_bus(&argument) {
        true => argument.env(BUS_VARIABLE).hide_env_values(true),
        false => argument,
    };
    let told = |argument: clap::Arg| match argument.get_help().filter(|_| is_bus(&argument)) {
        Some(help) => {
            let help = format!("{help} [env: {BUS_VARIABLE}]");
            argument.help(help)
        }
        None => argument,
    };
    command.mut_subcommands(|below| {
        if settings::ON_BUS.contains(&below.get_name()) {
            below.mut_args(with_variable)
        } else if settings::begins_with_bus(&below) {
            below.mut_args(told)
        } else {
            with_environment(below)
        }
    })
}

/// Adds the meaning of the exit statuses to the help and the manual page of every command.
fn with_statuses(command: clap::Command) -> clap::Command {
    command.after_help(STATUSES).mut_subcommands(with_statuses)
}

#[cfg(test)]
mod documented;

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// The value name of an option, or `nothing` for a flag. `NODE=MODEL|FILE`, for commands about several nodes, and
    /// `[NODE=]MODEL|FILE`, for commands about one node, count as the same name.
    fn meaning(argument: &clap::Arg) -> String {
        let names = argument.get_value_names().unwrap_or_default().join(" ");
        match argument.get_action().takes_values() {
            true => names.trim_start_matches("[NODE=]").trim_start_matches("NODE=").to_owned(),
            false => "nothing".to_owned(),
        }
    }

    /// Options that mean the same although their values have different names, each with the reason.
    const SAME: [(&str, &str); 7] = [
        ("fail-on", "changes have classes, findings have severities"),
        ("journal", "restore has to have one; test takes none for nowhere"),
        ("node", "simulate takes none for a device without node-ID"),
        ("node-id", "LSS can remove a node-ID, LMT can't"),
        ("profile", "of test a choice of cases, of explain the profile of a device: each is the usual word"),
        ("timeout", "of test and restore each wait has its own, WHAT=SPAN"),
        ("to", "where a capture is written, its name tells whether it is a format or a time"),
    ];

    fn walk(command: &clap::Command, path: &str, seen: &mut BTreeMap<String, Vec<(String, String)>>) {
        for argument in command.get_arguments().filter(|argument| !argument.is_hide_set()) {
            if let Some(long) = argument.get_long() {
                seen.entry(long.to_owned()).or_default().push((meaning(argument), path.to_owned()));
            }
        }
        for below in command.get_subcommands() {
            walk(below, &format!("{path} {}", below.get_name()), seen);
        }
    }

    #[test]
    fn an_option_means_one_thing_in_all_commands() {
        let (mut cli, mut seen) = (Cli::command(), BTreeMap::new());
        cli.build();
        walk(&cli, "canvass", &mut seen);
        assert!(seen.len() > 60, "{}", seen.len());
        for (option, uses) in seen {
            let differs = uses.iter().any(|(meaning, _)| *meaning != uses[0].0);
            assert!(!differs || SAME.iter().any(|(same, _)| *same == option), "--{option}: {uses:#?}");
        }
    }

    /// No command has an option `--json`, and each command that prints a result has the option `--format`.
    #[test]
    fn json_is_a_format_everywhere() {
        let (mut cli, mut seen) = (Cli::command(), BTreeMap::new());
        cli.build();
        walk(&cli, "canvass", &mut seen);
        assert!(!seen.contains_key("json"), "{:?}", seen["json"]);
        for command in
            ["test", "fuzz", "diagnose", "compare", "history", "verify", "scan", "doctor", "lss inquire", "sdo read"]
        {
            assert!(seen["format"].iter().any(|(_, path)| *path == format!("canvass {command}")), "{command}");
        }
    }
}
