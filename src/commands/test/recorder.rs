//! `--record`: all frames of a run as a capture.
//!
//! Comments of frames mark the beginning and end of each case ([`CaseMark`]). `--cct-markers` adds the marks of CiA's
//! test tool: frames of CAN-ID 7FFh that were not on the bus, with the number of the case's family as group, and the
//! case's place in the family.

use crate::destination::{Destination, complete_beginning_of};
use crate::output::{Output, diagnostic};
use anyhow::{Result, anyhow};
use canvass_analyzer::CaseMark;
use canvass_analyzer::wire::Wire;
use canvass_analyzer::wire::case_marker::{CAN_ID, CaseMarker, Verdict};
use canvass_suite::bench::{Annotate, Decoder};
use canvass_suite::case::Case;
use canvass_suite::catalogue;
use canvass_suite::runner::RunEvent;
use canvass_suite::verdict::Kind;
use canvass_traces::{Channels, Frame, Record, Recording, WriteOptions, Writer};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;

/// The capture. A thread of its own writes it, so that the tester does not wait for the disk.
pub struct Recorder {
    lines: Sender<Entry>,
    /// Whether marker frames of CiA's test tool mark the cases as well.
    cct_markers: bool,
    /// Number of frames passed to the recorder.
    frames: AtomicU64,
    /// The writing thread, until [`Recorder::finish`] has joined it.
    thread: Mutex<Option<JoinHandle<Result<()>>>>,
}

/// A message to the writing thread.
enum Entry {
    Frame(Record),
    /// Beginning of the case with this id.
    Begin(&'static str),
    /// End of the case, with its verdict.
    End(&'static str, Kind),
    /// A marker frame, which gets the time of the frame before it.
    Marker(Frame),
    /// End of the capture.
    Finish,
}

/// Adds the decoder's text to each frame before it is written.
pub struct Recorded<'a> {
    /// Makes the text of a frame.
    pub decoder: Decoder,
    /// The recorder that gets the frame.
    pub recorder: Option<&'a Recorder>,
    /// Number of frames written to the bundle, if there is one.
    pub bundled: Option<u64>,
}

impl Annotate for Recorded<'_> {
    fn annotate(&mut self, record: &Record) -> String {
        if let Some(recorder) = self.recorder {
            recorder.frame(record);
        }
        self.bundled.iter_mut().for_each(|frames| *frames += 1);
        self.decoder.annotate(record)
    }

    fn number(&self) -> u64 {
        let recorded = self.recorder.map(|recorder| recorder.frames.load(Ordering::Relaxed));
        recorded.or(self.bundled).unwrap_or_default()
    }
}

impl Recorder {
    /// Creates the capture before the device is touched. Only `force` overwrites a file: a recording of a device is
    /// hard to make again.
    pub fn create(path: &Path, force: bool, cct_markers: bool) -> Result<Self> {
        let (lines, entries) = channel();
        let (ready, begun) = sync_channel(1);
        let path = path.to_owned();
        let thread = std::thread::Builder::new().name("record".to_owned());
        let thread = thread.spawn(move || write(&path, force, &ready, &entries))?;
        // The thread has ended before it was ready; its result says why.
        match begun.recv() {
            Ok(()) => Ok(Self { lines, cct_markers, frames: AtomicU64::new(0), thread: Mutex::new(Some(thread)) }),
            Err(_) => Err(ended(thread).err().unwrap_or_else(|| anyhow!("the capture could not be created"))),
        }
    }

    fn frame(&self, record: &Record) {
        self.frames.fetch_add(1, Ordering::Relaxed);
        self.entry(Entry::Frame(record.clone()));
    }

    fn entry(&self, entry: Entry) {
        // The thread keeps an error of writing for the end: a capture that can't be written must not end the run.
        let _ = self.lines.send(entry);
    }

    /// Marks where a case begins and ends.
    pub fn event(&self, event: &RunEvent<'_>) {
        match event {
            RunEvent::CaseStarted { case, .. } => {
                self.entry(Entry::Begin(case.id));
                self.cct_marker(case, None);
            }
            RunEvent::CaseFinished(report) => {
                self.cct_marker(report.case, Some(marked(report.verdict.kind())));
                self.entry(Entry::End(report.case.id, report.verdict.kind()));
            }
            _ => {}
        }
    }

    /// Adds a marker frame of CiA's test tool. The marker gets the time of the frame before it: before the first frame,
    /// no marker is added.
    fn cct_marker(&self, case: &'static Case, verdict: Option<Verdict>) {
        if self.cct_markers && self.frames.load(Ordering::Relaxed) > 0 {
            let (group, number) = place_of(case);
            let marker = CaseMarker { group, case: number, verdict };
            self.frames.fetch_add(1, Ordering::Relaxed);
            self.entry(Entry::Marker(marker.to_frame(CAN_ID)));
        }
    }

    /// Completes the capture.
    pub fn finish(&self) -> Result<()> {
        // If the thread has ended already, the thread's result says why.
        let _ = self.lines.send(Entry::Finish);
        let thread = self.thread.lock().unwrap_or_else(PoisonError::into_inner).take();
        thread.map_or(Ok(()), ended)
    }
}

fn ended(thread: JoinHandle<Result<()>>) -> Result<()> {
    thread.join().unwrap_or_else(|_| Err(anyhow!("the recording thread failed: the capture is not complete")))
}

/// Writes the capture until the end message arrives or all senders are gone.
fn write(path: &Path, force: bool, ready: &SyncSender<()>, entries: &Receiver<Entry>) -> Result<()> {
    let destination = Destination::new(path, None, force)?;
    let sink = destination.open_growing(&Output::capture())?;
    let mut recording = Recording::create(sink, destination.format, destination.compression, &WriteOptions::default())?;
    let mut channels = Channels::default();
    channels.intern("can0");
    // The receiver waits for this message; it can't be gone.
    let _ = ready.send(());
    let (mut last, mut marks): (Option<Record>, Vec<String>) = (None, Vec::new());
    for entry in entries {
        let record = match (entry, &last) {
            (Entry::Frame(record), _) => record,
            (Entry::Marker(frame), Some(last)) => Record::new(last.timestamp, last.channel, frame),
            (Entry::Marker(_), None) => continue,
            (Entry::Begin(id), _) => {
                marks.push(CaseMark { id, verdict: None }.to_string());
                continue;
            }
            (Entry::End(id, kind), _) => {
                end(&mut marks, id, kind);
                continue;
            }
            (Entry::Finish, _) => break,
        };
        let record = if marks.is_empty() { record } else { record.with_comment(&marks.join("\n")) };
        marks.clear();
        recording.write(&record, &channels)?;
        last = Some(record);
    }
    recording.finish()?;
    complete_beginning_of(path, &recording)?;
    for (loss, frames) in recording.losses().iter() {
        diagnostic(&format!("canvass: the capture can't hold {} of {frames} frames", loss.name()));
    }
    Ok(())
}

/// Marks the end of a case. A case without frames gets no mark at all.
fn end(marks: &mut Vec<String>, id: &str, kind: Kind) {
    let begin = CaseMark { id, verdict: None }.to_string();
    if marks.pop_if(|mark| *mark == begin).is_none() {
        marks.push(CaseMark { verdict: Some(kind.title()), id }.to_string());
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

/// The number of the family, and the number of the case in the family; both from 1 and at most 255.
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
