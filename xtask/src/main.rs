//! The tasks of the project. With `--install`, a task installs missing programs.
//!
//! - `cargo xtask test`: checks for each change;
//! - `cargo xtask ci`: everything that must pass;
//! - `cargo xtask nightly`: longer checks;
//! - `cargo xtask docs`: the book;
//! - `cargo xtask peers`: tests that exchange captures with other people's programs;
//! - `cargo xtask browser`: tests that show the pages in Chromium;
//! - `cargo xtask fleet`: the workspace in `fleet`, with other readers of a lake;
//! - `cargo xtask bench`: the speed of canvass, compared with its peers; with `--instructions`, the instructions per
//!   frame;
//! - `cargo xtask memory`: the memory for captures of gigabytes;
//! - `cargo xtask storm`: ten million random frames for each simulated device;
//! - `cargo xtask attack`: changed files and misbehaving adapters, through every command;
//! - `cargo xtask rooms`: whether the folders of the crates use each other in one direction only;
//! - `cargo xtask incidents`: whether the diagnosis names what an operator does to the frames of a network, and accuses
//!   nobody in healthy ones;
//! - `cargo xtask worst`: the cost of the most expensive traffic, compared with usual traffic;
//! - `cargo xtask flaky`: the number of verdicts that change while other work keeps this machine busy;
//! - `cargo xtask screenshot`: the pictures in `docs`;
//! - `cargo xtask mutants`: how many random mutants of the simulated devices the suite and the fuzzer find; with
//!   `--tests`, how many mutants of a crate its own tests find;
//! - `cargo xtask alone`: whether a case alone and the same case in a whole run give the same verdict;
//! - `cargo xtask as-found`: whether a run, complete, interrupted or killed, leaves the simulated devices as it found
//!   them;
//! - `cargo xtask web`: the page with the decoder as WebAssembly; `web-test` tests it, `web-bench` measures it;
//! - `cargo xtask windows`: the program for Windows, and its tests by Wine;
//! - `cargo xtask dist`: the release files: archives, packages, images; with `--check`, each is installed, run and
//!   removed.

mod as_found;
mod attack;
mod bench;
mod browser;
mod ci;
mod compiled;
mod consent;
mod describing;
mod diagnosing;
mod dist;
mod docs;
mod flaky;
mod fleet;
mod fuzz;
mod incidents;
mod measure;
mod memory;
mod mutants;
mod packages;
mod peers;
mod python;
mod rooms;
mod run;
mod screenshot;
mod seed;
mod simulation;
mod storm;
mod target;
mod vcan;
mod venv;
mod web;
mod windows;
mod worst;

use anyhow::{Result, bail};

const USAGE: &str = "usage: cargo xtask [--install] COMMAND
    test | ci | nightly | docs
    peers | browser | python | wheel | fleet [--check] | vcan [WORDS...] | vcan-load
    fuzz [--for SECONDS] | attack [--for SPAN] [--seed N] | storm
    alone [--count N] [--seed N]
    as-found [--all] [--seed N] [--model ID]
    mutants [--seed D] [--count N] [--tests analyzer|suite]
    flaky [--runs N] [--at-once N] [--model ID]... [--select CASES] [--bus vcan|INTERFACE]
    bench [--instructions | --descriptions | --fleet] | memory | worst
    incidents [--seed N[,N...]] [--count N] | incidents --write CELL@SEED FILE
    rooms [CRATE...] | screenshot [NAME...] | web | web-test | web-bench | windows
    dist [--check] [PART...]";

fn main() -> Result<()> {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().map(std::path::Path::to_owned);
    std::env::set_current_dir(root.unwrap_or_else(|| ".".into()))?;
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    if words.iter().any(|word| word == consent::OPTION) {
        consent::give();
        words.retain(|word| word != consent::OPTION);
    }
    let more = words.get(1..).unwrap_or_default();
    match words.first().map(String::as_str) {
        Some("ci") => ci::ci(),
        Some("nightly") => ci::nightly(),
        Some("test") => ci::everyday(),
        Some("dist") => dist::dist(more),
        Some("docs") => docs::docs(),
        Some("peers") => peers::test(),
        Some("browser") => browser::test(),
        Some("python") => python::test(),
        Some("wheel") => python::wheel(),
        Some("bench") if more.first().is_some_and(|word| word == "--instructions") => bench::instructions(),
        Some("bench") if more.first().is_some_and(|word| word == "--descriptions") => bench::descriptions(),
        Some("bench") if more.first().is_some_and(|word| word == "--fleet") => fleet::bench::bench(),
        Some("bench") => bench::bench(),
        Some("alone") => run::run("cargo", &alone(more)),
        Some("as-found") => as_found::as_found(more),
        Some("attack") => attack::attack(more),
        Some("flaky") => flaky::flaky(more),
        Some("fleet") => fleet::command(more),
        Some("fuzz") => fuzz::command(more),
        Some("memory") => memory::memory(),
        Some("incidents") => incidents::incidents(more),
        Some("mutants") => mutants::mutants(more),
        Some("rooms") => rooms::rooms(more),
        Some("screenshot") => screenshot::screenshot(more),
        Some("storm") => storm::storm(),
        Some("vcan") => vcan::test(more),
        Some("vcan-load") => vcan::load(),
        Some("windows") if more.first().is_some_and(|word| word == "--check") => windows::step(),
        Some("windows") => windows::test(),
        Some("web") => web::build(),
        Some("web-bench") => web::bench(),
        Some("web-test") => web::test(),
        Some("web-bind") => web::bind(more),
        Some("worst") => worst::worst(),
        _ => bail!("{USAGE}"),
    }
}

/// The arguments of cargo for `canvass selftest --alone`, followed by `more`.
fn alone(more: &[String]) -> Vec<&str> {
    let selftest = ["run", "--release", "--locked", "--", "selftest", "--alone"];
    selftest.into_iter().chain(more.iter().map(String::as_str)).collect()
}
