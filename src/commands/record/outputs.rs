//! The files of a recorder: a full file is followed by a new one, and the oldest is deleted.

use crate::destination::{Destination, complete_beginning_of};
use crate::output::{Output, diagnostic, raw};
use anyhow::{Context, Result, bail};
use canvass_traces::{
    Channels, Duration, Format, Record, Recording, TimeBase, Timestamp, WriteError, WriteOptions, Writer,
};
use std::cell::Cell;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// When a new file begins, and how many files are kept.
#[derive(Clone, Copy)]
pub struct Rotation {
    /// Maximum size of a file in bytes.
    pub size: Option<u64>,
    /// Maximum time span of a file.
    pub time: Option<Duration>,
    /// Number of files kept of each output.
    pub keep: Option<u32>,
}

impl Rotation {
    const fn is_on(&self) -> bool {
        self.size.is_some() || self.time.is_some()
    }
}

/// All outputs of a recorder.
pub struct Outputs(Vec<Series>);

impl Outputs {
    /// Creates all files before recording starts, so that an unwritable path is reported at once.
    pub fn open(
        paths: &[PathBuf],
        format: Option<Format>,
        force: bool,
        rotation: Rotation,
        time_base: TimeBase,
    ) -> Result<Self> {
        let series = |path: &PathBuf| Series::open(path, format, force, rotation, time_base);
        paths.iter().map(series).collect::<Result<_>>().map(Self)
    }

    /// Writes a frame into every output.
    pub fn write(&mut self, record: &Record, channels: &Channels) -> Result<()> {
        self.0.iter_mut().try_for_each(|series| series.write(record, channels))
    }

    /// Passes all buffered bytes to the system, which keeps them even if this program is killed.
    pub fn flush(&mut self) -> Result<()> {
        self.0.iter_mut().try_for_each(|series| series.checked(Recording::flush))
    }

    /// Completes all files.
    pub fn finish(&mut self) -> Result<()> {
        self.0.iter_mut().try_for_each(Series::finish)
    }
}

/// One output: a file, or a series of files.
struct Series {
    path: PathBuf,
    format: Option<Format>,
    force: bool,
    rotation: Rotation,
    time_base: TimeBase,
    number: u32,
    recording: Recording,
    /// Number of bytes written into the current file.
    written: Rc<Cell<u64>>,
    /// Time of the current file's first frame.
    begun: Option<Timestamp>,
    files: VecDeque<PathBuf>,
}

impl Series {
    fn open(path: &Path, format: Option<Format>, force: bool, rotation: Rotation, time_base: TimeBase) -> Result<Self> {
        if rotation.is_on() && path.as_os_str() == "-" {
            bail!("standard output can't be split into files: --rotate-size and --rotate-time need a file");
        }
        let written = Rc::new(Cell::new(0));
        let first = if rotation.is_on() { numbered(path, 1) } else { path.to_owned() };
        let recording = create(&first, format, force, time_base, &written)?;
        Ok(Self {
            path: path.to_owned(),
            format,
            force,
            rotation,
            time_base,
            number: 1,
            recording,
            written,
            begun: None,
            files: VecDeque::from([first]),
        })
    }

    fn write(&mut self, record: &Record, channels: &Channels) -> Result<()> {
        if self.is_full(record.timestamp) {
            self.rotate()?;
        }
        self.begun.get_or_insert(record.timestamp);
        self.checked(|recording| recording.write(record, channels))
    }

    fn is_full(&self, now: Timestamp) -> bool {
        self.rotation.size.is_some_and(|size| self.written.get() >= size)
            || self.rotation.time.zip(self.begun).is_some_and(|(span, begun)| now.since(begun) >= span)
    }

    fn rotate(&mut self) -> Result<()> {
        self.complete()?;
        self.number += 1;
        let next = numbered(&self.path, self.number);
        self.recording = create(&next, self.format, self.force, self.time_base, &self.written)?;
        self.begun = None;
        self.files.push_back(next);
        while self.rotation.keep.is_some_and(|keep| self.files.len() > keep as usize) {
            if let Some(oldest) = self.files.pop_front() {
                std::fs::remove_file(&oldest).with_context(|| format!("can't remove {}", oldest.display()))?;
            }
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<()> {
        self.complete()?;
        for (loss, frames) in self.recording.losses().iter() {
            let (path, plural) = (self.path.display(), if frames == 1 { "" } else { "s" });
            diagnostic(&format!("canvass: {path} can't hold {} of {frames} frame{plural}", loss.name()));
        }
        Ok(())
    }

    /// Completes the current file.
    fn complete(&mut self) -> Result<()> {
        self.checked(Recording::finish)?;
        complete_beginning_of(self.files.back().unwrap_or(&self.path), &self.recording)
    }

    fn checked(&mut self, act: impl FnOnce(&mut Recording) -> Result<(), WriteError>) -> Result<()> {
        let path = self.files.back().unwrap_or(&self.path);
        act(&mut self.recording).with_context(|| path.display().to_string())
    }
}

fn create(
    path: &Path,
    format: Option<Format>,
    force: bool,
    time_base: TimeBase,
    written: &Rc<Cell<u64>>,
) -> Result<Recording> {
    let destination = Destination::new(path, format, force)?;
    written.set(0);
    let live = destination.is_stdout();
    let file: Box<dyn Write> = if live { Box::new(raw()) } else { destination.open_growing(&Output::capture())? };
    let sink = Box::new(Counted { file, written: Rc::clone(written) });
    // Frames in an MCAP file are readable at once only if the file has no chunks, which is usual for a live file. The
    // recorder flushes four times a second, and each flush completes a chunk: if the recorder is killed, chunks lose no
    // more frames.
    let options = WriteOptions { time_base, live, ..WriteOptions::default() };
    Ok(Recording::create(sink, destination.format, destination.compression, &options)?)
}

/// The name of the file with this number: `out.log.gz` becomes `out-0001.log.gz`.
fn numbered(path: &Path, number: u32) -> PathBuf {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    // The leading dot of a hidden file begins no extension.
    let at = name.get(1..).and_then(|rest| rest.find('.')).map_or(name.len(), |at| at + 1);
    let (stem, ending) = name.split_at(at);
    path.with_file_name(format!("{stem}-{number:04}{ending}"))
}

/// Counts the bytes written through it.
struct Counted {
    file: Box<dyn Write>,
    written: Rc<Cell<u64>>,
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.file.write(bytes)?;
        self.written.set(self.written.get() + n as u64);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_before_the_endings() {
        let of = |path: &str, number| numbered(Path::new(path), number);
        assert_eq!(of("x/out.log.gz", 1), Path::new("x/out-0001.log.gz"));
        assert_eq!(of("out", 12_345), Path::new("out-12345"));
        assert_eq!(of(".hidden.log", 2), Path::new(".hidden-0002.log"));
    }
}
