//! The program, end to end.
//!
//! Tests that need Unix give the reason after `cfg(unix)`: `cargo xtask windows`, which runs the others as programs of
//! Windows, prints it.

#[cfg(test)]
mod archive;
#[cfg(test)]
mod bounded;
#[cfg(test)]
mod bundle;
#[cfg(test)]
#[cfg(unix)] // the recipes are scripts of a POSIX shell
mod ci_page;
#[cfg(test)]
mod closed_output;
#[cfg(test)]
mod completion;
#[cfg(test)]
mod configurations;
#[cfg(test)]
mod conformance;
#[cfg(test)]
mod contract;
#[cfg(test)]
mod decode;
#[cfg(test)]
mod diagnose;
#[cfg(test)]
mod eds_check;
#[cfg(test)]
mod eds_convert;
#[cfg(test)]
mod eds_diff;
#[cfg(test)]
mod eds_from_device;
#[cfg(test)]
mod eds_show;
#[cfg(test)]
mod eds_verify;
#[cfg(test)]
mod events;
#[cfg(test)]
mod everyday;
#[cfg(test)]
#[cfg(unix)] // a script of a POSIX shell stands for the other program
mod fleet;
#[cfg(test)]
mod flooded;
#[cfg(test)]
mod fuzz;
#[cfg(test)]
mod history;
#[cfg(test)]
#[cfg(unix)] // the limit of memory is that of a POSIX shell, and Windows has no files of such names
mod hostile;
#[cfg(test)]
#[cfg(unix)] // a signal: `cargo xtask windows` presses Ctrl-C on a console
mod interrupted;
#[cfg(test)]
mod killed;
#[cfg(test)]
mod live;
#[cfg(test)]
mod lsp;
#[cfg(test)]
mod marks;
#[cfg(test)]
#[cfg(unix)] // what a process has needed stands in /proc
mod memory;
#[cfg(test)]
mod one_language;
#[cfg(test)]
mod other_clients;
#[cfg(test)]
#[cfg(unix)] // a signal ends what goes on for ever
mod outages;
#[cfg(test)]
#[cfg(unix)] // the documentation shows a POSIX shell
mod pages;
#[cfg(test)]
mod pcan;
#[cfg(test)]
mod printed;
#[cfg(test)]
#[cfg(unix)] // it is shown on pseudo-terminals
mod progress;
#[cfg(test)]
mod provenance;
#[cfg(test)]
mod proxy;
#[cfg(test)]
mod quarantine;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod rogues;
#[cfg(test)]
mod rows;
#[cfg(test)]
mod running;
#[cfg(test)]
mod schemas;
#[cfg(test)]
mod settings;
#[cfg(test)]
#[cfg(unix)] // pseudo-terminals, and what they say of themselves
mod terminals;
#[cfg(test)]
#[cfg(unix)] // signals, named pipes and /proc
mod waiting;
#[cfg(test)]
mod waivers;
#[cfg(test)]
mod welcome;
#[cfg(all(test, windows))]
mod windows;
