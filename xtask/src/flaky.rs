//! `cargo xtask flaky`: counts verdicts that change when the tester's machine is busy.
//!
//! The suite runs repeatedly against a simulated device in another process, over a real transport, while every
//! processor of this machine has other work. The simulated bus, whose time is virtual, gives the expected verdicts.
//! Only "inconclusive, because this machine was late" may replace a verdict, and seldom. With `--starve device` the
//! device gets no processor beside the other work; then "because the device was late as a whole" is allowed, too.

mod load;
mod options;
mod pair;
mod tally;

use crate::measure::{self, release};
use crate::run::{run, this_program};
use crate::vcan::{self, has_vcan};
use anyhow::{Context, Result, ensure};
use load::Load;
use options::{Options, Starved, Transport};
use pair::Pair;
use std::collections::VecDeque;
use std::sync::Mutex;
use std::thread;
use tally::{Run, Tally, Verdicts};

/// Maximum percentage of verdicts lost to a late machine.
const MOST_LATE: f64 = 1.0;

/// Maximum percentage of verdicts lost to a late machine if the device is starved.
const MOST_LATE_DEVICE: f64 = 2.0;

/// Repeats the suite and prints a row of the table in `docs/testing.md` for each model.
///
/// # Errors
/// If a verdict changes to anything but "inconclusive" for lateness, or if 1 % of the verdicts or more become
/// "inconclusive" for lateness (2 % if the device is starved).
pub fn flaky(arguments: &[String]) -> Result<()> {
    let options = Options::read(arguments)?;
    if !options.in_machine {
        run("cargo", &["build", "--release", "--locked", "--bin", "canvass"])?;
        println!("machine: {}, busy with a thread of other work for each processor", measure::machine());
        println!("{}", Tally::HEADING);
        if options.transport == Transport::Virtual && !has_vcan() {
            return on_machines(&options);
        }
    }
    let mut bad = Vec::new();
    for model in &options.models {
        let tally = of_model(model, &options)?;
        println!("{}", tally.row(model));
        for change in tally.changes() {
            eprintln!("{model}: {change}");
        }
        if tally.changed() > 0 {
            bad.push(format!("{model}: {} verdicts changed", tally.changed()));
        }
        let most = if options.starved == Starved::Device { MOST_LATE_DEVICE } else { MOST_LATE };
        if tally.late_share() >= most {
            bad.push(format!("{model}: {:.2} % lost to lateness", tally.late_share()));
        }
    }
    ensure!(bad.is_empty(), "{}", bad.join("; "));
    Ok(())
}

/// Runs in as many machines with vcan as there are processors, each with its share of the runs and its own load.
fn on_machines(options: &Options) -> Result<()> {
    let machines = thread::available_parallelism().map_or(1, |count| count.get() as u32).min(options.runs);
    let program = std::env::current_dir()?.join(release("canvass"));
    vcan::on_machines(program, machines, "flaky", &options.words(options.runs.div_ceil(machines)))
}

/// The path of the program. In a machine of its own this process has another working directory, so that the path is
/// absolute.
fn program(options: &Options) -> Result<String> {
    if !options.in_machine {
        return Ok(release("canvass"));
    }
    let own = this_program()?;
    let target = own.ancestors().nth(2).context("xtask lies in a folder of target")?;
    Ok(target.join("release/canvass").to_string_lossy().into_owned())
}

/// All repetitions with one model.
fn of_model(model: &str, options: &Options) -> Result<Tally> {
    let program = program(options)?;
    // The same cases first run over the transport on an idle machine: effects of the transport itself (no echo, no
    // known bit rate) are no effects of the load.
    let truth = pair::simulated(&program, model, options)?;
    let quiet = Pair::start(&program, model, options)?.test()?;
    let expected = Verdicts::expected(&truth, &quiet)?;
    let load = Load::start();
    let left = Mutex::new((0..options.runs).collect::<VecDeque<u32>>());
    let results: Vec<Result<Vec<Run>>> = thread::scope(|scope| {
        let workers: Vec<_> = (0..options.at_once)
            .map(|_| {
                scope.spawn(|| {
                    let mut runs = Vec::new();
                    while left.lock().is_ok_and(|mut left| left.pop_front().is_some()) {
                        runs.push(Pair::start(&program, model, options)?.test()?);
                    }
                    Ok(runs)
                })
            })
            .collect();
        let ended = workers.into_iter().map(std::thread::ScopedJoinHandle::join);
        ended.map(|ended| ended.unwrap_or_else(|_| Err(anyhow::anyhow!("a repetition panicked")))).collect()
    });
    load.stop();
    let mut tally = Tally::new(expected);
    for runs in results {
        for run in runs? {
            tally.add(&run);
        }
    }
    Ok(tally)
}
