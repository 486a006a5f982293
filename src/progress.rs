//! Progress of reading captures: on standard error, if that is a terminal and the output is not.

use crate::output::{Output, is_seen, is_terminal, show_progress};
use canvass_reports::escape::Printable;
use std::io::{self, Read};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Delay before the progress appears: most captures are read by then.
const PATIENCE: Duration = Duration::from_secs(1);
/// Interval between two updates.
const PAUSE: Duration = Duration::from_millis(200);

/// The progress of all captures of a command.
#[derive(Clone)]
pub struct Progress(Arc<ProgressState>);

struct ProgressState {
    begun: Instant,
    /// Size of all files in bytes.
    size: u64,
    read: AtomicU64,
    shown: Mutex<Option<Instant>>,
    output: Output,
}

/// A reader that counts its bytes.
pub struct Counted<R> {
    inner: R,
    progress: Progress,
}

impl Progress {
    /// Begins the progress of these files; `output` receives the decoded lines.
    pub fn of<'a>(files: impl IntoIterator<Item = &'a Path>, output: &Output) -> Self {
        let size = |path: &Path| std::fs::metadata(path).map_or(0, |file| file.len());
        Self(Arc::new(ProgressState {
            begun: Instant::now(),
            size: files.into_iter().map(size).sum(),
            read: AtomicU64::new(0),
            shown: Mutex::new(None),
            output: output.clone(),
        }))
    }

    /// Counts the bytes read through `inner`.
    pub fn count<R>(&self, inner: R) -> Counted<R> {
        Counted { inner, progress: self.clone() }
    }

    fn add(&self, bytes: u64) {
        let ProgressState { begun, read, shown, output, .. } = &*self.0;
        let read = read.fetch_add(bytes, Ordering::Relaxed) + bytes;
        let elapsed = begun.elapsed();
        if elapsed < PATIENCE || !is_seen() {
            return;
        }
        let mut shown = shown.lock().unwrap_or_else(PoisonError::into_inner);
        let is_early = shown.is_some_and(|shown| shown.elapsed() < PAUSE);
        // Decoded lines on the terminal show the progress themselves.
        if is_early || is_terminal() && output.has_written() {
            return;
        }
        *shown = Some(Instant::now());
        show_progress(&Printable::line(&told(read, self.0.size, elapsed)));
    }

    /// Ends the display.
    fn end(&self) {
        let mut shown = self.0.shown.lock().unwrap_or_else(PoisonError::into_inner);
        if shown.take().is_some() {
            show_progress(&Printable::line(""));
        }
    }
}

/// The text of the line: `34 of 120 MB (28 %), 17.0 MB/s, 5 s left`.
fn told(read: u64, size: u64, elapsed: Duration) -> String {
    const MEGA: f64 = 1e6;
    let (done, all) = (read.min(size) as f64, size as f64);
    let rate = read as f64 / elapsed.as_secs_f64().max(0.001);
    let left = ((all - done) / rate.max(1.0)).ceil();
    let percent = (done * 100.0 / all.max(1.0)).floor();
    format!("canvass: {:.0} of {:.0} MB ({percent} %), {:.1} MB/s, {left} s left", done / MEGA, all / MEGA, rate / MEGA)
}

impl<R: Read> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let bytes = self.inner.read(buffer)?;
        match bytes {
            0 => self.progress.end(),
            _ => self.progress.add(bytes as u64),
        }
        Ok(bytes)
    }
}

impl<R> Drop for Counted<R> {
    fn drop(&mut self) {
        self.progress.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rate_and_time_left_are_told() {
        let text = told(34_000_000, 120_000_000, Duration::from_secs(2));
        assert_eq!(text, "canvass: 34 of 120 MB (28 %), 17.0 MB/s, 6 s left");
        // The file has grown since its size was read.
        assert!(told(7, 5, Duration::ZERO).contains("(100 %)"));
    }
}
