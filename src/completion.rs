//! Shell completion for values of arguments: models, faults, cases, interfaces and so on.

use canvass_analyzer::findings;
use canvass_device::models::Model;
use canvass_device::{Fault, Liberty};
use canvass_suite::catalogue;
use canvass_suite::touch::Touch;
use canvass_traces::Format;
use clap::Command;
use clap_complete::engine::{ArgValueCompleter, CompletionCandidate, PathCompleter, ValueCompleter};
use std::ffi::OsStr;

/// The environment variable that a shell sets to ask for completions.
pub const VARIABLE: &str = "COMPLETE";

/// Returns the words that complete the typed beginning.
type Words = fn(&str) -> Vec<String>;

/// Adds the completions to all arguments of the commands.
pub fn with_candidates(command: Command) -> Command {
    let command = command.mut_args(|argument| match words(argument.get_id().as_str()) {
        Some(words) => argument.add(ArgValueCompleter::new(move |typed: &OsStr| candidates(typed, words))),
        None => argument,
    });
    command.mut_subcommands(with_candidates)
}

/// The completions for the argument with this id, in any command.
fn words(id: &str) -> Option<Words> {
    Some(match id {
        "bus" => buses,
        "device" | "devices" => devices,
        "select" | "exclude" => |typed| listed(typed, cases()),
        "allow" => {
            |typed| listed(typed, Touch::ALL.map(|touch| touch.name().to_owned()).into_iter().chain(["all".to_owned()]))
        }
        "fault" => |typed| listed(typed, faults()),
        "liberty" => |typed| listed(typed, liberties()),
        "threshold" => |_| thresholds(),
        "timeout" => |typed| {
            let waits = ["sdo=", "store=", "lss=", "boot-up=", "reaction=", "silence=", "client=", "reconnect="];
            listed(typed, waits.map(str::to_owned))
        },
        "id" => |_| explained(),
        _ => return None,
    })
}

fn candidates(typed: &OsStr, words: Words) -> Vec<CompletionCandidate> {
    let Some(typed) = typed.to_str() else { return Vec::new() };
    words(typed).into_iter().filter(|word| word.starts_with(typed)).map(CompletionCandidate::new).collect()
}

/// Completes the last item of a comma-separated list.
fn listed(typed: &str, words: impl IntoIterator<Item = String>) -> Vec<String> {
    let before = typed.rfind(',').map_or("", |comma| &typed[..=comma]);
    words.into_iter().map(|word| format!("{before}{word}")).collect()
}

fn cases() -> Vec<String> {
    catalogue::cases().into_iter().map(|case| case.id.to_owned()).collect()
}

fn faults() -> Vec<String> {
    Fault::ALL.iter().map(|fault| fault.id().to_owned()).collect()
}

fn liberties() -> Vec<String> {
    Liberty::ALL.iter().map(|liberty| liberty.id().to_owned()).collect()
}

fn models() -> impl Iterator<Item = String> {
    Model::all().iter().map(|model| model.id().to_owned())
}

fn thresholds() -> Vec<String> {
    let of = |rule: &'static findings::Metadata| {
        rule.thresholds.iter().map(|threshold| format!("{}.{}=", rule.id, threshold.name))
    };
    findings::all().flat_map(|rule| of(rule.metadata)).collect()
}

fn explained() -> Vec<String> {
    let rules = findings::all().map(|rule| rule.metadata.id.to_owned());
    let formats = Format::all().map(|format| format.id().to_owned());
    cases().into_iter().chain(faults()).chain(liberties()).chain(rules).chain(models()).chain(formats).collect()
}

/// Interfaces of this machine, and simulated devices; after the `+` of a simulated device, all faults.
fn buses(typed: &str) -> Vec<String> {
    match typed.rsplit_once('+').filter(|_| typed.starts_with("sim:")) {
        Some((before, _)) => faults().into_iter().map(|fault| format!("{before}+{fault}")).collect(),
        None => interfaces().into_iter().chain(models().map(|model| format!("sim:{model}"))).collect(),
    }
}

#[cfg(target_os = "linux")]
fn interfaces() -> Vec<String> {
    canvass_bus::socketcan::Link::can_interfaces()
}

#[cfg(not(target_os = "linux"))]
fn interfaces() -> Vec<String> {
    Vec::new()
}

/// Models and files, after the node-ID if one is typed.
fn devices(typed: &str) -> Vec<String> {
    let (before, path) = typed.find('=').map_or(("", typed), |at| typed.split_at(at + 1));
    let files = PathCompleter::file().complete(OsStr::new(path)).into_iter();
    let files = files.filter_map(|candidate| candidate.get_value().to_str().map(str::to_owned));
    models().chain(files).map(|name| format!("{before}{name}")).collect()
}
