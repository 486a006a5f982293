//! `--record`: the whole traffic of a run as a capture.
//!
//! Where a case begins and ends stands in the capture as CiA's test tool marks it, by a frame of CAN-ID 7FFh that was
//! not on the bus: `canvass decode` shows it. The number of the group is that of the case's family, that of the case its
//! place in the family.

use crate::destination::Destination;
use crate::output::{Output, diagnostic};
use anyhow::{Result, anyhow};
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::case_marker::{CAN_ID, CaseMarker, Verdict};
use canvass_suite::bench::{Annotate, Decoder};
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::runner::RunEvent;
use canvass_suite::verdict::Kind;
use canvass_traces::{Channels, Frame, Record, Recording, WriteOptions, Writer};
use std::path::Path;
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;

/// The capture. A thread of its own writes it: the tester does not wait for the disk.
pub struct Recorder {
    lines: Sender<Entry>,
    /// Until it has ended.
    thread: Mutex<Option<JoinHandle<Result<()>>>>,
}

/// What comes into the capture.
enum Entry {
    Frame(Record),
    /// Gets the time of the last frame.
    Marker(Frame),
    /// Nothing more comes.
    End,
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
    /// Begins the capture before the device is touched. A file that exists is overwritten only by `force`: it is as much
    /// work to get again as the device is slow.
    pub fn create(path: &Path, force: bool) -> Result<Self> {
        let (lines, entries) = channel();
        let (ready, begun) = sync_channel(1);
        let path = path.to_owned();
        let thread = std::thread::Builder::new().name("record".to_owned());
        let thread = thread.spawn(move || write(&path, force, &ready, &entries))?;
        // Whatever it ended with before it began is why.
        match begun.recv() {
            Ok(()) => Ok(Self { lines, thread: Mutex::new(Some(thread)) }),
            Err(_) => Err(ended(thread).err().unwrap_or_else(|| anyhow!("the capture could not be begun"))),
        }
    }

    fn frame(&self, record: &Record) {
        // A capture that can't be written is told of at the end.
        let _ = self.lines.send(Entry::Frame(record.clone()));
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
        let (group, number) = place_of(case);
        let marker = CaseMarker { group, case: number, verdict };
        let _ = self.lines.send(Entry::Marker(marker.to_frame(CAN_ID)));
    }

    /// Ends the capture, which is complete then.
    pub fn finish(&self) -> Result<()> {
        // If nobody takes it, the capture has ended already, and says why.
        let _ = self.lines.send(Entry::End);
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        thread.map_or(Ok(()), ended)
    }
}

fn ended(thread: JoinHandle<Result<()>>) -> Result<()> {
    thread.join().unwrap_or_else(|_| Err(anyhow!("the recorder failed: the capture is not complete")))
}

/// Writes the capture until nobody has anything for it any more.
fn write(path: &Path, force: bool, ready: &SyncSender<()>, entries: &Receiver<Entry>) -> Result<()> {
    let destination = Destination::new(path, None, force)?;
    let sink = destination.open_growing(&Output::capture())?;
    let mut recording = Recording::create(sink, destination.format, destination.compression, &WriteOptions::default())?;
    let mut channels = Channels::default();
    channels.intern("can0");
    // Who waits for it is there.
    let _ = ready.send(());
    let mut last: Option<Record> = None;
    for entry in entries {
        let record = match (entry, &last) {
            (Entry::Frame(record), _) => record,
            (Entry::Marker(frame), Some(last)) => Record::new(last.timestamp, last.channel, frame),
            (Entry::Marker(_), None) => continue,
            (Entry::End, _) => break,
        };
        recording.write(&record, &channels)?;
        last = Some(record);
    }
    recording.finish()?;
    for (loss, frames) in recording.losses().iter() {
        diagnostic(&format!("canvass: the capture can't hold {} of {frames} frames", loss.name()));
    }
    Ok(())
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
