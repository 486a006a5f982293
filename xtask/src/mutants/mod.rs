//! `cargo xtask mutants [--seed D,D] [--count N] [--exchanges N] [--only N,N]`: the suite and the fuzzer look for
//! random mutants of the simulated devices' own code. `--tests analyzer|suite [--within SECONDS]`: the tests of this
//! crate look for its random mutants; with `--within`, only tests that take no longer.
//!
//! All mutants are compiled into one program ([`rewrite`]) in a copy of the workspace ([`scratch`]), and each process
//! chooses one. Only mutants at reached places are drawn. The default seed is the date, so that nobody tunes to it.

mod area;
mod by_tests;
mod constants;
mod covered;
mod drawn;
mod find;
mod honest;
mod hunt;
mod parallel;
mod point;
mod reviewed;
mod rewrite;
mod scratch;
mod table;
mod tested;
mod variants;

use crate::seed::today;
use anyhow::{Context, Result, bail, ensure};
use area::Area;
use drawn::Mutant;
use hunt::{Fate, Hunt};
use reviewed::Reviewed;
use std::collections::BTreeSet;
use std::time::Instant;

/// Default number of mutants to try.
const COUNT: usize = 1_000;
/// Default number of exchanges of the fuzzer with each model.
const EXCHANGES: u64 = 20_000;

struct Wishes {
    /// One or several seeds: the program is built once for all.
    seeds: Vec<u64>,
    count: usize,
    exchanges: u64,
    /// The numbers of these mutants, which replace the random mutants.
    only: Vec<u32>,
    /// The crate whose own tests look for its mutants.
    tests: Option<&'static Area>,
    /// Limit of the tests' duration in seconds of processor time.
    within: Option<u64>,
}

/// Draws mutants, runs the tools on them and prints the results.
///
/// # Errors
/// If the program can't be built, a tool finds something on the device without a mutant, or the list of equivalent
/// mutants names code that no longer exists.
pub fn mutants(args: &[String]) -> Result<()> {
    let wishes = Wishes::read(args)?;
    if let Some(area) = wishes.tests {
        return by_tests::by_tests(area, &wishes);
    }
    let area = &area::DEVICE;
    let reviewed = Reviewed::read(area)?;
    let mut sources = scratch::read(area)?;
    // Rows of the list whose code no longer exists are reported at once, not after minutes of building.
    ensure_current(&reviewed, &drawn::all(&sources))?;
    let begun = Instant::now();
    scratch::prepare(area, &mut sources)?;
    let program = hunt::build(area)?;
    let all = drawn::all(&sources);
    ensure_current(&reviewed, &all)?;
    eprintln!("{} mutants, built in {} s", all.len(), begun.elapsed().as_secs());
    let mut tried = Vec::new();
    for &seed in &wishes.seeds {
        let begun = Instant::now();
        let hunt = Hunt::new(program.clone(), seed, wishes.exchanges);
        let right = hunt.right(&area.scratch())?;
        let fates = hunt.all(&wishes.choose(&all, &right.reached, seed), &right)?;
        let unreached = all.iter().filter(|mutant| !right.reached.contains(&mutant.place)).collect::<Vec<_>>();
        write_unreached(&unreached)?;
        let (table, line) = table::table(&fates, &reviewed);
        let (suite, together) = line.shares();
        tried.extend(fates);
        println!("{table}\nseed {seed}, {} mutants in {} s", line.run(), begun.elapsed().as_secs());
        println!(
            "of those that show on the bus and are not equivalent: {suite:.1} % by the suite, {together:.1} % with the fuzzer"
        );
        println!("{} of {} mutants are in places that are never reached: {UNREACHED}", unreached.len(), all.len());
    }
    tell(&tried, &reviewed)
}

fn ensure_current(reviewed: &Reviewed, all: &[Mutant]) -> Result<()> {
    let stale = reviewed.stale(all);
    ensure!(
        stale.is_empty(),
        "the code of these rows in xtask/equivalent-mutants*.toml no longer exists, remove them: {stale:#?}"
    );
    Ok(())
}

/// The list of mutants at places that neither suite nor fuzzer reaches.
const UNREACHED: &str = "target/mutants/unreached.txt";
/// The list of mutants that changed no frame.
const UNSEEN: &str = "target/mutants/unseen.txt";
/// The list of mutants that survived, as rows for the list of equivalent mutants.
const SURVIVORS: &str = "target/mutants/survivors.toml";
/// The list of mutants that were found.
const FOUND: &str = "target/mutants/found.txt";

/// Writes the lists of mutants that were not found.
fn tell(fates: &[Fate], reviewed: &Reviewed) -> Result<()> {
    let lost = |fate: &&Fate| !fate.is_found() && reviewed.reason(&fate.mutant).is_none();
    let (unseen, survived): (Vec<&Fate>, Vec<&Fate>) = fates.iter().filter(lost).partition(|fate| fate.is_unseen());
    for fate in &survived {
        println!("{}", table::describe(fate));
    }
    let rows: Vec<String> = survived.iter().map(|fate| reviewed::row(&fate.mutant)).collect();
    std::fs::write(SURVIVORS, rows.join("\n"))?;
    let describe = |fates: Vec<&Fate>| fates.into_iter().map(table::describe).collect::<Vec<_>>().join("\n");
    std::fs::write(UNSEEN, describe(unseen))?;
    std::fs::write(FOUND, describe(fates.iter().filter(|fate| fate.is_found()).collect()))?;
    Ok(())
}

fn write_unreached(unreached: &[&Mutant]) -> Result<()> {
    let line = |mutant: &&Mutant| format!("{}:{} {}: {}\n", mutant.file, mutant.line, mutant.function, mutant.change);
    Ok(std::fs::write(UNREACHED, unreached.iter().map(line).collect::<String>())?)
}

impl Wishes {
    fn read(args: &[String]) -> Result<Self> {
        let mut wishes = Self {
            seeds: vec![today()?],
            count: COUNT,
            exchanges: EXCHANGES,
            only: Vec::new(),
            tests: None,
            within: None,
        };
        let mut args = args.iter();
        while let Some(name) = args.next() {
            let value = args.next().with_context(|| format!("{name} needs a value"))?;
            match &**name {
                "--seed" => {
                    wishes.seeds = value.split(',').map(str::parse).collect::<Result<_, _>>().context("--seed")?
                }
                "--count" => wishes.count = value.parse().context("--count")?,
                "--exchanges" => wishes.exchanges = value.parse().context("--exchanges")?,
                "--only" => {
                    wishes.only = value.split(',').map(str::parse).collect::<Result<_, _>>().context("--only")?
                }
                "--tests" => {
                    let area = area::TESTED.iter().find(|area| area.name == value);
                    wishes.tests = Some(area.context("--tests: expected analyzer or suite")?);
                }
                "--within" => wishes.within = Some(value.parse().context("--within")?),
                other => bail!("expected --seed, --count, --exchanges, --only, --tests or --within, found {other}"),
            }
        }
        Ok(wishes)
    }

    fn choose(&self, all: &[Mutant], reached: &BTreeSet<u32>, seed: u64) -> Vec<Mutant> {
        match self.only.is_empty() {
            true => drawn::draw_reached(all, reached, seed, self.count),
            false => all.iter().filter(|mutant| self.only.contains(&mutant.number)).cloned().collect(),
        }
    }
}
