//! `--bundle`: records the run and packs everything about it into one file.

use super::course::Course;
use super::recorder::Recorder;
use super::reports::{Kept, ReportFormat, Reports};
use crate::bundle::setup::Setup;
use crate::bundle::{Contents, Frames};
use crate::destination::refuse_existing;
use crate::devices::named;
use crate::provenance::described_by;
use crate::status::{Failure, Status};
use crate::whole_file::WholeFile;
use anyhow::{Context, Result};
use canvass_bus::Bus;
use canvass_bus::transcript::{Transcriber, Transcript};
use canvass_traces::Record;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// A bundle that is being written.
pub struct Bundle {
    file: WholeFile,
    frames: Frames,
    result: Kept,
    page: Kept,
}

impl Bundle {
    /// Creates the bundle before the device is touched, so that an unwritable path is reported at once.
    pub fn begin(path: &Path, force: bool, reports: &mut Reports) -> Result<Self> {
        if !force {
            refuse_existing(path)?;
        }
        let (result, page) = (reports.keep(ReportFormat::Json), reports.keep(ReportFormat::Html));
        Ok(Self { file: WholeFile::create(path)?, frames: Frames::begin()?, result, page })
    }

    /// Runs the cases, and packs the result.
    pub fn run(
        mut self,
        mut course: Course<'_>,
        bus: &mut dyn Bus,
        recorder: Option<&Recorder>,
        cancel: &AtomicBool,
    ) -> Result<Status, Failure> {
        let mut observe = |record: &Record| self.frames.take(record);
        let mut transcriber = Transcriber::new(bus, &mut observe);
        let ended = course.run(&mut transcriber, recorder, cancel)?;
        let transcript = transcriber.finish();
        let was_interrupted = cancel.load(Ordering::SeqCst);
        let setup = setup(&course, &transcript, was_interrupted);
        let (args, is_over) = (course.args, ended.is_over);
        let status = ended.finish(course.reports)?;
        if is_over {
            let description = described_by(&args.bus, args.device.as_deref()).map(PathBuf::from);
            let contents = Contents {
                frames: self.frames,
                transcript: &transcript,
                setup,
                result: self.result.take(),
                page: self.page.take(),
                description: description.as_deref(),
                waivers: args.waivers.as_deref(),
            };
            let written = self.file.writer()?.write_all(&contents.pack()?);
            written.context("can't write the bundle")?;
            self.file.complete()?;
        }
        Ok(status)
    }
}

/// The options and inputs of the run, for `run.json`.
fn setup(course: &Course<'_>, transcript: &Transcript, was_interrupted: bool) -> Setup {
    let Course { args, cases, options, target, today, .. } = course;
    let why = match (transcript.trouble(), was_interrupted, &options.power_cycle) {
        (Some(trouble), _, _) => Some(trouble.to_owned()),
        (None, true, _) => Some("the user interrupted it".to_owned()),
        (None, false, Some(_)) => Some("a command switched the supply of the device (--power-cycle)".to_owned()),
        (None, false, None) => None,
    };
    let mut setup = Setup::new(options);
    setup.bus.clone_from(&args.bus);
    setup.node = target.node.raw();
    setup.device = args.device.as_deref().map(|device| named(device).to_owned());
    // Only waivers depend on the day; without them a simulated run gives the same bundle on every day.
    if args.waivers.is_some() {
        setup.day.clone_from(today);
    }
    setup.seed = args.seed;
    setup.cases = cases.iter().map(|case| case.id.to_owned()).collect();
    setup.not_repeatable = why;
    setup
}
