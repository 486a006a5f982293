//! `cargo xtask mutants --tests CRATE`: the share of a crate's mutants that its own tests find.

use super::area::Area;
use super::reviewed::{self, Reviewed};
use super::tested::{Fate, Outcome, Programs};
use super::{Wishes, drawn, ensure_current, scratch};
use anyhow::Result;
use std::time::Instant;

/// Draws mutants of a crate, runs its tests on each and prints the result.
pub fn by_tests(area: &Area, wishes: &Wishes) -> Result<()> {
    let reviewed = Reviewed::read(area)?;
    let mut sources = scratch::read(area)?;
    ensure_current(&reviewed, &drawn::all(&sources))?;
    scratch::prepare(area, &mut sources)?;
    let programs = Programs::build(area)?;
    let tests = programs.tests(wishes.within)?;
    let all = drawn::all(&sources);
    let (count, time) = (tests.count(), tests.time().as_secs());
    eprintln!("{} mutants; {count} tests, which take {time} s without one", all.len());
    let mut tried = Vec::new();
    for &seed in &wishes.seeds {
        let begun = Instant::now();
        let chosen = match wishes.only.is_empty() {
            true => drawn::draw(all.clone(), seed, wishes.count),
            false => all.iter().filter(|mutant| wishes.only.contains(&mutant.number)).cloned().collect(),
        };
        let fates = tests.all(&chosen)?;
        eprintln!("seed {seed}: {} mutants in {} s", fates.len(), begun.elapsed().as_secs());
        tried.extend(fates);
    }
    println!(
        "| folder | run | caught | came to no end | missed | in no test's way | equivalent | caught of the others |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for service in area.services() {
        println!("{}", row(service, tried.iter().filter(|fate| fate.mutant.service == service), &reviewed));
    }
    println!("{}", row("**all**", tried.iter(), &reviewed));
    tell(area, &tried, &reviewed)
}

fn row<'a>(name: &str, fates: impl Iterator<Item = &'a Fate>, reviewed: &Reviewed) -> String {
    let (mut run, mut caught, mut hung, mut missed, mut unreached, mut equivalent) = (0, 0, 0, 0, 0, 0);
    for fate in fates {
        run += 1;
        let counted = match fate.outcome {
            Outcome::Caught(_) => &mut caught,
            Outcome::Hung(_) => &mut hung,
            _ if reviewed.reason(&fate.mutant).is_some() => &mut equivalent,
            Outcome::Missed => &mut missed,
            Outcome::Unreached => &mut unreached,
        };
        *counted += 1;
    }
    // A mutant that never ends counts as detected.
    let share = 100.0 * f64::from(caught + hung) / f64::from((run - equivalent).max(1));
    format!("| {name} | {run} | {caught} | {hung} | {missed} | {unreached} | {equivalent} | {share:.1} % |")
}

/// Lists the missed mutants, also as rows for the list of equivalent mutants.
fn tell(area: &Area, fates: &[Fate], reviewed: &Reviewed) -> Result<()> {
    let is_lost = |fate: &&Fate| {
        matches!(fate.outcome, Outcome::Missed | Outcome::Unreached) && reviewed.reason(&fate.mutant).is_none()
    };
    let lost: Vec<&Fate> = fates.iter().filter(is_lost).collect();
    for fate in &lost {
        println!("{}\n    {:?}", fate.mutant.describe(area), fate.outcome);
    }
    let rows: Vec<String> = lost.iter().map(|fate| reviewed::row(&fate.mutant)).collect();
    Ok(std::fs::write(area.scratch().join("missed.toml"), rows.join("\n"))?)
}
