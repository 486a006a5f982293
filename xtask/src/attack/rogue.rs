//! Runs commands on misbehaving adapters: each must end in time, and report every loss.

use super::FOLDER;
use super::limited::Program;
use super::rogues::Rogue;
use super::tally::Tally;
use anyhow::{Context, Result};
use std::sync::Mutex;
use std::time::Duration;

/// The commands; `BUS` stands for the adapter, `OUT` for a file.
const COMMANDS: [&str; 5] = [
    "test BUS --node 5 --for 3s --journal OUT.journal --format json",
    "scan BUS --for 3s",
    "fuzz BUS --node 5 --for 3s --seed 1 --format json",
    "record BUS OUT.log --for 3s",
    "monitor BUS --for 3s --format json",
];

/// Time limit in addition to the three seconds of `--for`: for opening the adapter, for a device that does not boot,
/// and for restoring.
const MOST: Duration = Duration::from_secs(20);

/// Runs every command on every adapter; most of the time is waiting.
pub fn attack(program: &Program) -> Result<Tally> {
    let tally = Mutex::new(Tally::default());
    std::thread::scope(|scope| {
        for (n, rogue) in (0..).zip(Rogue::ALL) {
            let tally = &tally;
            scope.spawn(move || {
                for (m, command) in COMMANDS.iter().enumerate() {
                    let failed = one(program, rogue, command, &format!("{FOLDER}/rogue-{n}-{m}"), tally);
                    if let (Err(error), Ok(mut tally)) = (failed, tally.lock()) {
                        tally.failures.push(format!("{rogue:?}: canvass {command}: {error:#}"));
                    }
                }
            });
        }
    });
    Ok(tally.into_inner().unwrap_or_default())
}

fn one(program: &Program, rogue: Rogue, command: &str, out: &str, tally: &Mutex<Tally>) -> Result<()> {
    let bus = format!("slcan:tcp://{}", rogue.start()?);
    let args: Vec<String> = command.split(' ').map(|word| word.replace("BUS", &bus).replace("OUT", out)).collect();
    let run = program.run(&args);
    if let Ok(mut tally) = tally.lock() {
        tally.rogues += 1;
        if let Some(failure) = tally.take(&run, &args) {
            tally.failures.push(format!("{rogue:?}: {failure}"));
        }
    }
    anyhow::ensure!(run.took < MOST, "took {:.1} s", run.took.as_secs_f64());
    // If the adapter seems to refuse the commands, `record` does not open it and ends with status 3.
    if command.starts_with("record") && run.status != Some(3) {
        let told = run.stderr.lines().find_map(|line| line.strip_prefix("canvass: ")?.split_once(" frames recorded"));
        let told: usize =
            told.map(|(frames, _)| frames.parse()).transpose()?.context("the program does not report the number")?;
        let written =
            std::fs::read(format!("{out}.log"))?.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()).count();
        anyhow::ensure!(told == written, "{told} frames are reported as recorded, but {written} are");
    }
    Ok(())
}
