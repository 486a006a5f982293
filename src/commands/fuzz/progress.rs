//! Progress of a fuzzing run, on a terminal.

use crate::output::{diagnostic, is_seen, show_progress};
use canvass_fuzzer::campaign::{self, Outcome};
use canvass_reports::escape::Printable;
use canvass_traces::Duration;
use std::time::Instant;

/// A line of the terminal that is rewritten.
pub struct Progress {
    begun: Instant,
    shown: Option<Instant>,
    span: Option<Duration>,
    terminal: bool,
}

/// Maximum number of updates per second.
const RATE: u128 = 5;

impl Progress {
    /// Begins the display; `span` is the time limit of the run.
    pub fn new(span: Option<Duration>) -> Self {
        Self { begun: Instant::now(), shown: None, span, terminal: is_seen() }
    }

    /// Updates the line, at most [`RATE`] times a second, if standard error is a terminal.
    pub fn show(&mut self, state: &campaign::Progress<'_>) {
        if !self.terminal || self.shown.is_some_and(|shown| shown.elapsed().as_millis() < 1_000 / RATE) {
            return;
        }
        self.shown = Some(Instant::now());
        let elapsed = self.begun.elapsed().as_secs_f64();
        let of = self.span.map(|span| format!(" of {span}")).unwrap_or_default();
        let (executions, rate) = (state.executions, per_second(state.executions, elapsed));
        let pairs = state.coverage.exercised();
        let violations = state.violations;
        show_progress(&Printable::line(&format!(
            "{elapsed:.0} s{of}: {executions} exchanges, {rate}/s, {pairs} pairs of state and command, \
             {violations} violations"
        )));
    }

    /// Prints the totals at the end of the run.
    pub fn end(&self, outcome: &Outcome) {
        if self.terminal {
            show_progress(&Printable::line(""));
        }
        let elapsed = self.begun.elapsed().as_secs_f64();
        let (executions, rate) = (outcome.executions, per_second(outcome.executions, elapsed));
        diagnostic(&format!("canvass: {executions} exchanges in {elapsed:.1} s, {rate}/s"));
    }
}

fn per_second(executions: u64, elapsed: f64) -> u64 {
    if elapsed > 0.0 { (executions as f64 / elapsed) as u64 } else { 0 }
}
