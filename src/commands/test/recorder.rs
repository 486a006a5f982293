//! `--record`: the whole traffic of a run as a capture.
//!
//! Where a case begins and ends stands in the capture as CiA's test tool marks it, by a frame of CAN-ID 7FFh that was
//! not on the bus: `canvass decode` shows it. The number of the group is that of the case's family, that of the case its
//! place in the family.

use crate::destination::Destination;
use crate::output::{Output, diagnostic};
use anyhow::Result;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::case_marker::{CAN_ID, CaseMarker, Verdict};
use canvass_conformance::bench::{Annotate, Decoder};
use canvass_conformance::case::Case;
use canvass_conformance::catalogue;
use canvass_conformance::runner::RunEvent;
use canvass_conformance::verdict::Kind;
use canvass_traces::{Channels, Record, Recording, WriteError, WriteOptions, Writer};
use std::cell::RefCell;
use std::path::Path;

/// The capture. The bench hands over the frames, the runner the begin and end of cases: both while the other holds it.
pub struct Recorder(RefCell<State>);

struct State {
    recording: Recording,
    channels: Channels,
    /// The last frame: markers have its time.
    last: Option<Record>,
    failed: Option<WriteError>,
}

/// What the analyzer says of each frame, which goes into the capture on its way.
pub struct Recorded<'a> {
    /// Makes the text.
    pub decoder: Decoder,
    /// Gets the frame.
    pub recorder: Option<&'a Recorder>,
}

impl Annotate for Recorded<'_> {
    fn annotate(&mut self, record: &Record) -> String {
        if let Some(recorder) = self.recorder {
            recorder.frame(record);
        }
        self.decoder.annotate(record)
    }
}

impl Recorder {
    /// Begins the capture before the device is touched. A file that exists is overwritten, as that of a report is.
    pub fn create(path: &Path) -> Result<Self> {
        let destination = Destination::new(path, None, true)?;
        let sink = destination.open(&[], &Output::default())?;
        let recording = Recording::create(sink, destination.format, destination.compression, &WriteOptions::default())?;
        let mut channels = Channels::default();
        channels.intern("can0");
        Ok(Self(RefCell::new(State { recording, channels, last: None, failed: None })))
    }

    fn frame(&self, record: &Record) {
        let mut state = self.0.borrow_mut();
        state.last = Some(record.clone());
        state.write(record);
    }

    /// Marks where a case begins and ends.
    pub fn event(&self, event: &RunEvent<'_>) {
        match event {
            RunEvent::CaseStarted { case, .. } => self.mark(case, None),
            RunEvent::CaseFinished(report) => self.mark(report.case, Some(marked(report.verdict.kind()))),
            _ => {}
        }
    }

    fn mark(&self, case: &'static Case, verdict: Option<Verdict>) {
        let mut state = self.0.borrow_mut();
        let (group, number) = place_of(case);
        let marker = CaseMarker { group, case: number, verdict };
        if let Some(last) = state.last.clone() {
            let marked = Record::new(last.timestamp, last.channel, marker.to_frame(CAN_ID));
            state.write(&marked);
        }
    }

    /// Ends the capture.
    pub fn finish(self) -> Result<()> {
        let mut state = self.0.into_inner();
        state.recording.finish()?;
        for (loss, frames) in state.recording.losses().iter() {
            diagnostic(&format!("canvass: the capture can't hold {} of {frames} frames", loss.name()));
        }
        match state.failed {
            Some(error) => Err(error.into()),
            None => Ok(()),
        }
    }
}

impl State {
    fn write(&mut self, record: &Record) {
        if self.failed.is_none() {
            self.failed = self.recording.write(record, &self.channels).err();
        }
    }
}

const fn marked(kind: Kind) -> Verdict {
    match kind {
        Kind::Pass => Verdict::PASS,
        Kind::Tolerated | Kind::Deviation => Verdict::WARNING,
        Kind::NotApplicable | Kind::Inconclusive => Verdict::SKIPPED,
        Kind::Fail | Kind::Error => Verdict::FAIL,
    }
}

/// The number of the family among all families, and of the case in it, both from 1 and at most 255.
fn place_of(case: &Case) -> (u8, u8) {
    let (mut group, mut number, mut family) = (0_u8, 0_u8, "");
    for known in catalogue::cases() {
        if known.family() != family {
            (family, number) = (known.family(), 0);
            group = group.saturating_add(1);
        }
        number = number.saturating_add(1);
        if known.id == case.id {
            break;
        }
    }
    (group, number)
}
