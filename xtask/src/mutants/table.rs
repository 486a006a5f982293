//! The table of results by service.

use super::area;
use super::hunt::{Fate, Outcome};
use super::reviewed::Reviewed;
use std::fmt::Write;

/// A line of the table.
#[derive(Clone, Copy, Default)]
pub struct Line {
    run: usize,
    suite: usize,
    recorded: usize,
    fuzzer: usize,
    both: usize,
    survived: usize,
    equivalent: usize,
    unseen: usize,
    hung: usize,
}

impl Line {
    fn of<'a>(fates: impl Iterator<Item = &'a Fate>, reviewed: &Reviewed) -> Self {
        let mut line = Self::default();
        for fate in fates {
            line.run += 1;
            let (suite, fuzzer) = (fate.suite.is_found(), fate.fuzzer.is_found());
            line.suite += usize::from(suite);
            line.recorded += usize::from(matches!(fate.suite, Outcome::Recorded(_)));
            line.fuzzer += usize::from(fuzzer);
            line.both += usize::from(suite && fuzzer);
            if suite || fuzzer {
                continue;
            }
            let place = if reviewed.reason(&fate.mutant).is_some() {
                &mut line.equivalent
            } else if fate.is_unseen() {
                &mut line.unseen
            } else if fate.has_hung() {
                &mut line.hung
            } else {
                &mut line.survived
            };
            *place += 1;
        }
        line
    }

    /// Number of mutants tried.
    pub const fn run(&self) -> usize {
        self.run
    }

    const fn found(&self) -> usize {
        self.suite + self.fuzzer - self.both
    }

    /// The percentages of mutants that the suite finds, and that either tool finds, among the mutants that show on the
    /// bus and are not equivalent.
    pub fn shares(&self) -> (f64, f64) {
        let all = (self.found() + self.survived).max(1) as f64;
        (100.0 * self.suite as f64 / all, 100.0 * self.found() as f64 / all)
    }

    fn row(&self, name: &str) -> String {
        let (suite, together) = self.shares();
        let Self { run, suite: by_suite, recorded, fuzzer, both, survived, equivalent, unseen, hung } = self;
        format!(
            "| {name} | {run} | {by_suite} ({recorded}) | {fuzzer} | {both} | {survived} | {equivalent} | {unseen} | {hung} | {suite:.1} % | {together:.1} % |"
        )
    }
}

/// The table of all services, and its last line.
pub fn table(fates: &[Fate], reviewed: &Reviewed) -> (String, Line) {
    let mut text = "| service | run | found by the suite (of these only recorded) | by the fuzzer | by both | survived | equivalent | not seen on the bus | hung | suite | together |\n|---|---|---|---|---|---|---|---|---|---|---|\n".to_owned();
    for service in area::DEVICE.services() {
        let line = Line::of(fates.iter().filter(|fate| fate.mutant.service == service), reviewed);
        if line.run > 0 {
            let _ = writeln!(text, "{}", line.row(service));
        }
    }
    let all = Line::of(fates.iter(), reviewed);
    let _ = writeln!(text, "{}", all.row("**all**"));
    (text, all)
}

/// The place and the change of a mutant.
pub fn describe(fate: &Fate) -> String {
    let mutant = &fate.mutant;
    let told = |name: &str, outcome: &Outcome| match outcome {
        Outcome::Found(what) | Outcome::Recorded(what) => format!("{name}: {what}"),
        outcome => format!("{name}: {outcome:?}"),
    };
    format!("{}\n    {}; {}", mutant.describe(&area::DEVICE), told("suite", &fate.suite), told("fuzzer", &fate.fuzzer))
}
