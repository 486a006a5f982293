//! The measure: many cells, counted by operator and by service; and healthy networks.

use super::cell::{Cell, Outcome};
use super::draw::Draw;
use super::judge::{self, Verdict};
use super::network::{Base, Events, Known, Network};
use super::open::Open;
use super::play::play;
use canvass_analyzer::findings::Severity;
use std::collections::{BTreeMap, HashMap};
use std::fmt::Write;

/// A measured cell.
pub struct Measured {
    cell: Cell,
    seed: u64,
    outcome: Outcome,
    /// Why the cell can't be known.
    reason: Option<String>,
}

/// Counts of verdicts.
#[derive(Default)]
struct Counts {
    verdicts: HashMap<Verdict, usize>,
    open: usize,
}

/// The results of a measure.
#[derive(Default)]
pub struct Measure {
    /// The cells.
    pub cells: Vec<Measured>,
    /// The healthy networks.
    pub healthy: usize,
    /// The healthy networks in which something is found that is worse than an information.
    pub accused: Vec<String>,
    /// The informations on healthy networks, by rule.
    pub informed: BTreeMap<&'static str, usize>,
}

/// The values of a function for all inputs, in their order, computed on all cores.
fn on_all_cores<I: Sync, O: Send>(inputs: &[I], compute: impl Fn(&I) -> O + Sync) -> Vec<O> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let share = inputs.len().div_ceil(cores).max(1);
    std::thread::scope(|scope| {
        let work = |part: &'_ [I]| part.iter().map(&compute).collect::<Vec<O>>();
        let threads: Vec<_> = inputs.chunks(share).map(|part| scope.spawn(move || work(part))).collect();
        threads.into_iter().flat_map(|thread| thread.join().expect("a cell does not panic")).collect()
    })
}

impl Measure {
    /// Measures `count` cells with each seed. The sorts take turns, so that one with many fields, or one that every
    /// network has, does not outweigh the others.
    pub fn cells(&mut self, seeds: &[u64], count: usize) {
        let open = Open::read();
        for seed in seeds {
            let sorts = by_sort(*seed);
            let share = count.div_ceil(sorts.len());
            let mut rows: Vec<_> = on_all_cores(&sorts, |cells| {
                let measured = cells.iter().filter_map(|cell| Some((*cell, cell.measure(*seed)?)));
                measured.take(share).collect::<Vec<_>>().into_iter()
            });
            let turns = (0..share).flat_map(|_| rows.iter_mut().filter_map(Iterator::next).collect::<Vec<_>>());
            for (cell, outcome) in turns.take(count) {
                let reason = open.reason(&cell.to_string()).map(str::to_owned);
                self.cells.push(Measured { cell, seed: *seed, outcome, reason });
            }
        }
    }

    /// Diagnoses `count` healthy networks with each seed.
    pub fn healthy(&mut self, seeds: &[u64], count: usize) {
        for seed in seeds {
            let numbers: Vec<usize> = (0..count).collect();
            let diagnosed = on_all_cores(&numbers, |number| {
                let network = healthy(*seed, *number);
                let results = judge::diagnose(&play(&network.plan, &HashMap::new()), &network.descriptions());
                let told = results.findings.iter();
                told.map(|finding| (finding.rule.id, finding.severity, judge::show(0, finding))).collect::<Vec<_>>()
            });
            for (number, findings) in diagnosed.into_iter().enumerate() {
                self.healthy += 1;
                let (informed, accused): (Vec<_>, Vec<_>) =
                    findings.into_iter().partition(|(_, severity, _)| *severity == Severity::Info);
                informed.iter().for_each(|(rule, ..)| *self.informed.entry(rule).or_default() += 1);
                if let Some((.., worst)) = accused.first() {
                    self.accused.push(format!("healthy/{number}@{seed}: {worst}"));
                }
            }
        }
    }

    /// The share of cells named first or second among those that can be known.
    pub fn share(&self) -> f64 {
        let mut counts = Counts::default();
        self.cells.iter().for_each(|measured| counts.add(measured));
        counts.share()
    }

    /// The whole report.
    pub fn report(&self) -> String {
        let mut text = String::new();
        let by_operator = self.table("operator", |measured| measured.cell.operator.row().to_owned());
        let by_service = self.table("service", |measured| measured.cell.sort.group.to_owned());
        let _ = writeln!(text, "{by_operator}\n{by_service}");
        let healthy = self.healthy;
        let _ = writeln!(text, "healthy networks accused: {} of {healthy}", self.accused.len());
        self.accused.iter().for_each(|accused| {
            let _ = writeln!(text, "  {accused}");
        });
        let _ = writeln!(text, "informations on them: {:?}\n", self.informed);
        self.misses(&mut text);
        text
    }

    fn table(&self, head: &str, row: impl Fn(&Measured) -> String) -> String {
        let (mut rows, mut all) = (BTreeMap::<String, Counts>::new(), Counts::default());
        for measured in &self.cells {
            rows.entry(row(measured)).or_default().add(measured);
            all.add(measured);
        }
        let mut text = format!(
            "| {head} | cells | can't be known | first | second | later | missed | wrong | first or second |\n"
        );
        text.push_str("|---|---:|---:|---:|---:|---:|---:|---:|---:|\n");
        for (name, counts) in rows.iter().map(|(name, counts)| (name.as_str(), counts)).chain([("all", &all)]) {
            let _ = writeln!(text, "| {name} {}", counts.row());
        }
        text
    }

    fn misses(&self, text: &mut String) {
        let is_named = |verdict: Verdict| matches!(verdict, Verdict::First | Verdict::Second);
        let missed =
            self.cells.iter().filter(|measured| measured.reason.is_none() && !is_named(measured.outcome.verdict));
        for measured in missed {
            let Measured { cell, seed, outcome, .. } = measured;
            let _ = writeln!(text, "{:?} {cell}@{seed}: {}", outcome.verdict, outcome.truth);
            for finding in outcome.findings.iter().take(2) {
                let _ = writeln!(text, "    {finding}");
            }
        }
        text.push_str("cargo xtask incidents --write CELL@SEED FILE writes one of them as a log of candump\n");
    }
}

impl Counts {
    fn add(&mut self, measured: &Measured) {
        match measured.reason {
            Some(_) => self.open += 1,
            None => *self.verdicts.entry(measured.outcome.verdict).or_default() += 1,
        }
    }

    fn of(&self, verdict: Verdict) -> usize {
        self.verdicts.get(&verdict).copied().unwrap_or(0)
    }

    fn share(&self) -> f64 {
        let all: usize = self.verdicts.values().sum();
        (self.of(Verdict::First) + self.of(Verdict::Second)) as f64 / all.max(1) as f64
    }

    fn row(&self) -> String {
        let cells = self.open + self.verdicts.values().sum::<usize>();
        let counts: Vec<String> = Verdict::ALL.iter().map(|verdict| self.of(*verdict).to_string()).collect();
        format!("| {cells} | {} | {} | {:.1} % |", self.open, counts.join(" | "), 100.0 * self.share())
    }
}

/// A healthy network: the bases and the knowledge of them take turns.
pub fn healthy(seed: u64, number: usize) -> Network {
    let (base, known) = (Base::ALL[number % Base::ALL.len()].0, Known::ALL[number / Base::ALL.len() % 3].0);
    Network::new(base, known, Events::None, Draw::new(seed, &format!("healthy/{number}")))
}

/// The cells of each sort in a random order; the sorts too.
fn by_sort(seed: u64) -> Vec<Vec<Cell>> {
    let mut draw = Draw::new(seed, "cells");
    let mut sorts = BTreeMap::<String, Vec<Cell>>::new();
    for cell in Cell::all() {
        sorts.entry(cell.sort.id()).or_default().push(cell);
    }
    let mut sorts: Vec<Vec<Cell>> = sorts.into_values().collect();
    sorts.iter_mut().for_each(|cells| draw.shuffle(cells));
    draw.shuffle(&mut sorts);
    sorts
}
