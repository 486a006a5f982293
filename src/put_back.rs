//! Restores a device from the journal of an interrupted run.

use crate::devices::describe;
use crate::output::diagnostic;
use crate::status::{Failure, Status};
use anyhow::{Context, anyhow};
use canvass_bus::Bus;
use canvass_reports::conformance::dictionary::{lines, sentence};
use canvass_suite::bench::{Bench, Options, Target, Timing};
use canvass_suite::journal::Interrupted;
use canvass_suite::runner;
use canvass_traces::Record;
use canvass_traces::small_file::{self, OF_PROGRAM};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Reads a journal.
pub fn read(path: &Path) -> Result<Interrupted, Failure> {
    let text = small_file::read_text(path, OF_PROGRAM).with_context(|| format!("can't read {}", path.display()))?;
    Ok(Interrupted::read(&text).with_context(|| format!("{} is no journal", path.display()))?)
}

/// Restores a device, and removes the journal if everything was restored.
pub fn put_back(
    bus: &mut dyn Bus,
    device: &str,
    timing: Timing,
    interrupted: &Interrupted,
    journal: &Path,
) -> Result<Status, Failure> {
    let known = if device.is_empty() { None } else { Some(describe(device)?) };
    let target = Target::known(interrupted.node, device.to_owned(), known);
    let options = Options { timing, ..Options::default() };
    let (cancel, mut annotate) = (AtomicBool::new(false), |_: &Record| String::new());
    let mut bench = Bench::new(bus, &target, &options, &mut annotate, &cancel);
    let comparison = runner::put_back(&mut bench, interrupted).map_err(Failure::unreachable)?;
    if !comparison.is_as_found() {
        lines(&comparison).iter().for_each(|line| diagnostic(&format!("canvass: {line}")));
        let path = journal.display();
        diagnostic(&format!("canvass: not everything on node {} could be restored; {path} stays", interrupted.node));
        return Ok(Status::Findings);
    }
    std::fs::remove_file(journal).map_err(|error| anyhow!("can't remove {}: {error}", journal.display()))?;
    let values = interrupted.values.len();
    diagnostic(&format!("canvass: node {} is restored ({values} values)", interrupted.node));
    diagnostic(&format!("canvass: {}", sentence(&comparison)));
    Ok(Status::Good)
}
