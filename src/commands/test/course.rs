//! A run of cases, whose events go to the recorder, the reports and the provenance.

use super::Args;
use super::recorder::{Recorded, Recorder};
use super::reports::Reports;
use crate::output::diagnostic;
use crate::provenance::Collected;
use crate::status::{Failure, Status};
use crate::whole_file::write_whole;
use anyhow::Result;
use canvass_bus::Bus;
use canvass_suite::bench::{Bench, Decoder, Evidence, Options, Target};
use canvass_suite::case::Case;
use canvass_suite::runner::{CaseReport, EndedEarly, Plan, RunError, RunEvent, Summary, run};
use canvass_suite::waiver::{Waivers, suggested};
use std::sync::atomic::AtomicBool;

/// Everything that a run needs.
pub struct Course<'a> {
    pub args: &'a Args,
    pub cases: &'a [&'static Case],
    pub options: &'a Options,
    pub target: &'a Target,
    pub waivers: Waivers,
    /// The day by which waivers are judged.
    pub today: String,
    pub provenance: Collected,
    pub reports: Reports,
}

/// The end of a run.
pub struct Ended {
    summary: Result<Summary, RunError>,
    /// Whether the run reached its end, so that there is something to report.
    pub is_over: bool,
    recorded: Result<()>,
}

impl Course<'_> {
    /// Runs the cases.
    pub fn run(&mut self, bus: &mut dyn Bus, recorder: Option<&Recorder>, cancel: &AtomicBool) -> Result<Ended> {
        let mut annotate =
            Recorded { decoder: Decoder::new(self.target), recorder, bundled: self.args.bundle.as_ref().map(|_| 0) };
        let shuffle = self.args.choice.shuffle;
        let plan =
            Plan { cases: self.cases, bus: &self.args.bus, bit_rate: bus.bit_rate(), seed: self.args.seed, shuffle };
        let mut bench = Bench::new(bus, self.target, self.options, &mut annotate, cancel);
        let (mut is_over, mut recorded) = (false, Ok(()));
        let mut finished: Vec<CaseReport> = Vec::new();
        let summary = run(&mut bench, &plan, &mut |event: &RunEvent<'_>| {
            recorder.iter().for_each(|recorder| recorder.event(event));
            match event {
                RunEvent::RunStarted(info) => self.provenance.node(info.node, info.device.clone()),
                RunEvent::CaseFinished(report) if self.args.waivers.is_some() || self.args.write_waivers.is_some() => {
                    // The caller only needs to know whether a waiver applied. Without the evidence, a report takes
                    // little memory.
                    finished.push(CaseReport { evidence: Evidence::default(), ..(*report).clone() });
                }
                RunEvent::RunFinished(_) => {
                    is_over = true;
                    // The reports contain the hash of the complete capture.
                    recorded = recorder.map_or(Ok(()), Recorder::finish);
                    recorded = std::mem::replace(&mut recorded, Ok(())).and(self.suggest_waivers(&finished));
                    self.end(&finished);
                }
                _ => {}
            }
            // The device is restored in any case; an error of a report is reported afterwards.
            self.reports.event(event);
        });
        if let (Some(recorder), false) = (recorder, is_over) {
            recorded = recorder.finish();
        }
        if let Ok(summary) = &summary {
            self.advise(summary);
        }
        Ok(Ended { summary, is_over, recorded })
    }

    /// Prints which options help if cases were not run or not judged, or something was left changed.
    fn advise(&self, summary: &Summary) {
        if summary.ended_early == Some(EndedEarly::TimeIsOver) {
            diagnostic("canvass: --for says how long the run may take");
        }
        if summary.undescribed > 0 {
            diagnostic("canvass: --device MODEL or --device FILE.eds describes the device");
        }
        if let (false, Some(journal)) = (summary.is_as_found, &self.options.journal) {
            let journal = journal.display();
            diagnostic(&format!("canvass: canvass restore {} --journal {journal} tries again", self.args.bus));
        }
    }

    /// Writes a waiver file for what failed.
    fn suggest_waivers(&self, finished: &[CaseReport]) -> Result<()> {
        let Some(path) = &self.args.write_waivers else { return Ok(()) };
        // A year is long enough to mend most firmware, and short enough to be asked again.
        let next_year = self.today.get(..4).and_then(|year| year.parse::<u32>().ok()).map_or(2100, |year| year + 1);
        let last = format!("{next_year}{}", self.today.get(4..).unwrap_or_default());
        let reports: Vec<&CaseReport> = finished.iter().collect();
        let Some(text) = suggested(&reports, &self.args.bus, &last) else {
            diagnostic(&format!("canvass: nothing failed that is not excused: {} is not written", path.display()));
            return Ok(());
        };
        write_whole(path, text.as_bytes())
    }

    /// Prints the warnings that need the results of all cases.
    fn end(&mut self, finished: &[CaseReport]) {
        let idle = self.waivers.idle(&self.today, &finished.iter().collect::<Vec<_>>());
        idle.iter().for_each(|notice| self.reports.event(&RunEvent::Noticed(notice)));
        self.args.record.iter().for_each(|path| self.provenance.file("recording", path));
        self.reports.comes_from(&self.provenance.0);
    }
}

impl Ended {
    /// Completes the reports; returns the exit status.
    pub fn finish(self, reports: Reports) -> Result<Status, Failure> {
        // A run that tested nothing has no report; the reports of the run before stay.
        let reported = if self.is_over { reports.finish() } else { Ok(()) };
        self.recorded?;
        reported?;
        let summary = self.summary.map_err(Failure::unreachable)?;
        let is_good = summary.is_good() && summary.is_as_found && !summary.cancelled;
        Ok(if is_good { Status::Good } else { Status::Findings })
    }
}
