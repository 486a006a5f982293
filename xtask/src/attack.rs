//! `cargo xtask attack [--for 5m] [--seed N]`: malicious files and adapters against the program.
//!
//! Real captures, descriptions, results and journals are changed at random, from a seed, and given to every command
//! that reads them. No run may panic, exceed its memory or time, or lose a frame without a report: see [`account`].
//! [`rogue`]: misbehaving adapters.

mod account;
mod chance;
mod limited;
mod mutation;
mod rogue;
#[path = "../../tests/program/rogues.rs"]
mod rogues;
mod seeds;
mod tally;

use crate::run::{run, this_program};
use anyhow::{Context, Result, bail, ensure};
use chance::Chance;
use limited::Program;
use mutation::Mutation;
use seeds::Seeds;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use tally::Tally;

/// The usual duration, for CI.
const USUAL: Duration = Duration::from_secs(90);
/// The folder for changed files and failures.
const FOLDER: &str = "target/attack";
/// Number of threads: one for each processor of CI's machines.
const THREADS: u64 = 2;

/// Builds the program, and attacks it for the time in `args`.
///
/// # Errors
/// If the program can't be built, or fails.
pub fn attack(args: &[String]) -> Result<()> {
    let (mut span, mut seed, mut is_child) = (USUAL, 1, false);
    let mut args = args.iter();
    while let Some(arg) = args.next() {
        match &**arg {
            "--for" => span = parse_span(args.next().context("--for needs a time, such as 5m")?)?,
            "--seed" => seed = args.next().context("--seed needs a number")?.parse().context("--seed")?,
            "--built" => is_child = true,
            other => bail!("expected --for SPAN or --seed N, found {other}"),
        }
    }
    if is_child {
        return attack_built(span, seed);
    }
    run("cargo", &["build", "--locked"])?;
    by_child(span, seed)
}

/// Attacks the program that is already built.
///
/// # Errors
/// If the program fails.
pub fn built(span: &str) -> Result<()> {
    by_child(parse_span(span)?, 1)
}

fn by_child(span: Duration, seed: u64) -> Result<()> {
    // The system reports the largest memory of all children of a process, so the attack runs in a process that has no
    // compiler among its children.
    let this = this_program()?;
    let args = ["attack", "--built", "--for", &format!("{}s", span.as_secs()), "--seed", &seed.to_string()];
    run(&this.to_string_lossy(), &args)
}

fn attack_built(span: Duration, seed: u64) -> Result<()> {
    let _ = std::fs::remove_dir_all(FOLDER);
    std::fs::create_dir_all(FOLDER)?;
    let program = Program::built()?;
    let begun = Instant::now();
    let mut tally = rogue::attack(&program)?;
    let seeds = Seeds::gather(&program, Path::new(FOLDER))?;
    let (next, total) = (AtomicU64::new(0), Mutex::new(Tally::default()));
    std::thread::scope(|scope| {
        for thread in 0..THREADS {
            let (program, seeds, next, total) = (&program, &seeds, &next, &total);
            scope.spawn(move || {
                let mut tally = Tally::default();
                while begun.elapsed() < span {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    one(program, seeds, seed, number, thread, &mut tally);
                }
                if let Ok(mut total) = total.lock() {
                    total.add(tally);
                }
            });
        }
    });
    tally.add(total.into_inner().unwrap_or_default());
    println!("seed {seed}, {} s\n{tally}", begun.elapsed().as_secs());
    ensure!(tally.failures.is_empty(), "{} attacks succeeded:\n{}", tally.failures.len(), tally.failures.join("\n"));
    Ok(())
}

/// Runs every command for its kind on one changed file.
fn one(program: &Program, seeds: &Seeds, seed: u64, number: u64, thread: u64, tally: &mut Tally) {
    let mut chance = Chance::new(seed, number);
    let original = seeds.any(&mut chance);
    let (mutation, bytes) = Mutation::random(original, seeds, &mut chance);
    let path = format!("{FOLDER}/{thread}-input.{}", original.ending);
    if let Err(error) = std::fs::write(&path, &bytes) {
        tally.failures.push(format!("{path}: {error}"));
        return;
    }
    tally.inputs += 1;
    let mut failed = Vec::new();
    for command in original.kind.commands(&mut chance) {
        let args: Vec<String> = command.split(' ').map(|word| word.replace("FILE", &path)).collect();
        failed.extend(tally.take(&program.run(&args), &args));
    }
    if original.kind == seeds::SeedKind::Capture {
        match account::account(program, original, mutation, &bytes, &path, thread) {
            Ok(accounted) => failed.extend(tally.account(accounted)),
            Err(error) => failed.push(format!("{error:#}")),
        }
    }
    for failure in failed {
        let kept = format!("{FOLDER}/failed-{number}.{}", original.ending);
        let _ = std::fs::write(&kept, &bytes);
        tally.failures.push(format!("{kept} ({}, {mutation:?}): {failure}", original.name));
    }
}

/// `90s` or `5m`.
fn parse_span(text: &str) -> Result<Duration> {
    let (number, unit) = text.split_at(text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len()));
    let number: u64 = number.parse().with_context(|| format!("expected a time such as 90s or 5m, found \"{text}\""))?;
    match unit {
        "s" | "" => Ok(Duration::from_secs(number)),
        "m" | "min" => Ok(Duration::from_secs(60 * number)),
        "h" => Ok(Duration::from_secs(3_600 * number)),
        _ => bail!("expected a time such as 90s or 5m, found \"{text}\""),
    }
}

/// The rows of the original file, for changes that keep rows.
pub(crate) fn rows(bytes: &[u8]) -> Vec<&[u8]> {
    bytes.split_inclusive(|&byte| byte == b'\n').collect()
}
