//! `canvass test` and `canvass restore` on the simulated bus, and their messages to the user.

use super::request::Wanted;
use super::watched::{Moments, Seen, Watched};
use super::world::{Subject, World};
use anyhow::{Context, Result};
use canvass_analyzer::dictionary::KnownDevice;
use canvass_bus::Bus;
use canvass_reports::conformance::dictionary::lines;
use canvass_suite::bench::{Bench, Options, Target};
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::comparison::Comparison;
use canvass_suite::journal::Interrupted;
use canvass_suite::runner::{self, Plan, RunEvent};
use canvass_suite::touch::Touch;
use canvass_traces::{Frame, Record};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::path::Path;

/// The events of a run.
#[derive(Default)]
struct Told {
    /// Each finished case: its id, the number of frames before its beginning and at its end, its verdict.
    cases: Vec<(&'static str, u64, u64, &'static str)>,
    begun_at: u64,
    /// Number of cases that have begun.
    begun: usize,
    /// Number of frames that the tester had sent when the last case ended.
    closing: usize,
    comparison: Option<Comparison>,
    notices: Vec<String>,
}

pub fn test(world: &mut World, wanted: &Wanted) -> Result<Value> {
    let (journal, switch) = (world.journal_path(), world.switch_path());
    let _ = std::fs::remove_file(&journal);
    let cases = chosen(&wanted.select)?;
    let options = options(wanted, &journal, &switch)?;
    let moments = Moments {
        interrupt: wanted.interrupt,
        kill: wanted.kill.clone(),
        journal: journal.clone(),
        switch,
        ..Moments::default()
    };
    let (seen, mut told) = (Seen::default(), Told::default());
    let (subject, state) = world.current()?;
    let bit_rate = state.bus.bit_rate();
    let plan = Plan { cases: &cases, bus: &subject.address, bit_rate, seed: 0, shuffle: None };
    let target = Target::of(subject.model, subject.node);
    let mut bus = Watched { bus: &mut state.bus, moments: &moments, seen: &seen };
    let mut annotate = |_: &Record| String::new();
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &moments.cancel);
    let ended = runner::run(&mut bench, &plan, &mut |event| told.hear(event, &seen));
    drop(bench);
    state.journal = std::fs::read_to_string(&journal).ok();
    let mut answer = told.answer(&seen);
    match ended {
        Ok(summary) => answer["is_as_found"] = summary.is_as_found.into(),
        Err(error) => answer["failed"] = error.to_string().into(),
    }
    for (frame, state) in seen.kills.into_inner() {
        world.put_away(format!("kill {frame}"), state);
    }
    Ok(answer)
}

/// The options of the run.
fn options(wanted: &Wanted, journal: &Path, switch: &Path) -> Result<Options> {
    let allow = wanted.allow.iter().map(|word| word.parse()).collect::<Result<BTreeSet<Touch>, _>>()?;
    let power_cycle = wanted.power_cycle.then(|| format!("touch '{}'", switch.display()));
    let (zero_point_is_stored, journal) = (wanted.zero_point_stored, Some(journal.to_owned()));
    Ok(Options { allow, power_cycle, zero_point_is_stored, journal, ..Options::default() })
}

pub fn restore(world: &mut World) -> Result<Value> {
    let (subject, state) = world.current()?;
    let Some(journal) = &state.journal else { return Ok(json!({ "had_journal": false, "lines": [], "sent": [] })) };
    let interrupted = Interrupted::read(journal)?;
    let target = target(&interrupted, subject);
    let (seen, moments, options) = (Seen::default(), Moments::default(), Options::default());
    let mut bus = Watched { bus: &mut state.bus, moments: &moments, seen: &seen };
    let mut annotate = |_: &Record| String::new();
    let mut bench = Bench::new(&mut bus, &target, &options, &mut annotate, &moments.cancel);
    let compared = runner::put_back(&mut bench, &interrupted);
    drop(bench);
    let mut answer = json!({ "had_journal": true, "sent": shown(&seen.sent.borrow()) });
    match compared {
        Ok(comparison) => compare(&mut answer, &comparison),
        Err(error) => answer["failed"] = error.to_string().into(),
    }
    if answer["is_as_found"] == true {
        state.journal = None;
    }
    Ok(answer)
}

/// The device as `canvass restore` knows it, from the journal.
fn target(interrupted: &Interrupted, subject: &Subject) -> Target {
    let known = (!interrupted.device.is_empty()).then(|| KnownDevice::clone(subject.model.device()));
    Target::known(interrupted.node, interrupted.device.clone(), known)
}

fn chosen(ids: &[String]) -> Result<Vec<&'static Case>> {
    if ids.is_empty() {
        return Ok(catalogue::cases());
    }
    ids.iter().map(|id| catalogue::find(id).with_context(|| format!("there is no case {id}"))).collect()
}

impl Told {
    fn hear(&mut self, event: &RunEvent<'_>, seen: &Seen) {
        match event {
            RunEvent::OtherClients(_) => {}
            RunEvent::CaseStarted { .. } => {
                self.begun_at = seen.frames.get();
                self.begun += 1;
            }
            RunEvent::CaseFinished(report) => {
                let verdict = report.verdict.kind().name();
                self.cases.push((report.case.id, self.begun_at, seen.frames.get(), verdict));
                self.closing = seen.sent.borrow().len();
            }
            RunEvent::DictionaryCompared(comparison) => self.comparison = Some((*comparison).clone()),
            RunEvent::Noticed(notice) => self.notices.push((*notice).to_owned()),
            RunEvent::RunStarted(_) | RunEvent::RunFinished(_) => {}
        }
    }

    fn answer(self, seen: &Seen) -> Value {
        let sent = seen.sent.borrow();
        let closing = sent.get(self.closing..).unwrap_or_default();
        let mut answer = json!({
            "frames": seen.frames.get(),
            "begun": self.begun,
            "cases": self.cases,
            "notices": self.notices,
            "closing": shown(closing),
        });
        if let Some(comparison) = &self.comparison {
            compare(&mut answer, comparison);
        }
        answer
    }
}

/// Adds to the answer whether the device is as found, and the lines about the object dictionary that a user reads.
fn compare(answer: &mut Value, comparison: &Comparison) {
    answer["is_as_found"] = comparison.is_as_found().into();
    answer["lines"] = lines(comparison).into();
}

fn shown(frames: &[Frame]) -> Vec<String> {
    frames.iter().map(Frame::to_string).collect()
}
