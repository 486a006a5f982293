//! The options of a command with their values: read from clap's command line, so that none is forgotten.

use canvass_reports::provenance::{Choice, ChosenBy};
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command};
use std::path::PathBuf;

/// The typed command.
#[derive(Clone, Debug, Default)]
pub struct Typed {
    /// Options and arguments that affect the result.
    pub options: Vec<Choice>,
    /// The settings file, if it sets something for the command.
    pub settings: Option<PathBuf>,
}

/// Options that do not affect the result: they concern outputs, or the provenance holds their values elsewhere. Runs
/// that differ only in these options have the same result.
const OF_NO_CONSEQUENCE: [&str; 21] = [
    "help",
    "bus",
    "old",
    "new",
    "seed",
    "version",
    "color",
    "format",
    "report",
    "output",
    "force",
    "quality",
    "quality_out",
    "bundle",
    "record",
    "write_waivers",
    "note",
    "date",
    "dry_run",
    "verbose",
    "files",
];

impl Typed {
    /// Reads the options of the subcommand; arguments in `set` have their default from the settings file.
    pub fn of(command: &Command, matches: &ArgMatches, set: &[&str], settings: Option<PathBuf>) -> Self {
        let Some((name, matches)) = matches.subcommand() else { return Self::default() };
        let Some(command) = command.find_subcommand(name) else { return Self::default() };
        let options =
            command.get_arguments().filter(|argument| !OF_NO_CONSEQUENCE.contains(&argument.get_id().as_str()));
        Self { options: options.map(|argument| choice(argument, matches, set)).collect(), settings }
    }
}

fn choice(argument: &Arg, matches: &ArgMatches, set: &[&str]) -> Choice {
    let id = argument.get_id().as_str();
    let name = argument.get_long().unwrap_or(id).to_owned();
    let text = |text: &std::ffi::OsStr| text.to_string_lossy().into_owned();
    let mut default: Vec<String> = argument.get_default_values().iter().map(|value| text(value)).collect();
    let takes_values = argument.get_action().takes_values();
    if !takes_values {
        default = vec!["no".to_owned()];
    }
    let source = matches.try_contains_id(id).ok().and_then(|_| matches.value_source(id));
    let by = match source {
        Some(ValueSource::CommandLine) => ChosenBy::CommandLine,
        Some(ValueSource::EnvVariable) => ChosenBy::Environment,
        Some(_) if set.contains(&id) => ChosenBy::Settings,
        _ => ChosenBy::Default,
    };
    let given = || matches.get_raw(id).map(|values| values.map(text).collect()).unwrap_or_default();
    let value = match by {
        ChosenBy::Default => default.clone(),
        _ if !takes_values => vec!["yes".to_owned()],
        _ => given(),
    };
    Choice { name, value, default, by }
}

/// Replaces the value of an option by the value in force.
pub fn resolve(options: &mut [Choice], name: &str, value: Vec<String>) {
    if let Some(choice) = options.iter_mut().find(|choice| choice.name == name) {
        if choice.by == ChosenBy::Default {
            choice.default.clone_from(&value);
        }
        choice.value = value;
    }
}
