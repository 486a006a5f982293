//! Standard input, pipes and devices as live sources: while they have no data, the output so far is flushed, and
//! Ctrl-C ends them.

use crate::interrupt::Interrupt;
use crate::output::Output;
use std::fs;
use std::io::{self, Read};
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread;
use std::time::Duration;

/// Interval between two checks for Ctrl-C while there is no data.
const LOOK: Duration = Duration::from_millis(50);
const CHUNK: usize = 64 * 1024;

/// Reads what `open` opens, flushes `output` before each wait, and ends on Ctrl-C.
///
/// A thread opens and reads the source, as neither can be interrupted: opening a named pipe waits until another
/// program writes into it.
pub fn live<R: Read>(
    open: impl FnOnce() -> io::Result<R> + Send + 'static,
    output: Output,
    interrupt: Interrupt,
) -> impl Read + Send + 'static {
    let (sender, chunks) = sync_channel(4);
    thread::spawn(move || match open() {
        Ok(source) => read_all(source, &sender),
        // The receiver gets the error; if the receiver is gone, nobody needs the error.
        Err(error) => _ = sender.send(Err(error)),
    });
    LiveSource { chunks, chunk: io::Cursor::default(), output, interrupt }
}

/// Whether reading a file may block: a pipe, a terminal, a device, or a file that the kernel generates (files in /proc
/// claim to be regular and empty).
pub fn may_wait(file: &Path) -> bool {
    fs::metadata(file).is_ok_and(|metadata| !metadata.is_dir() && (!metadata.is_file() || metadata.len() == 0))
}

fn read_all(mut source: impl Read, chunks: &SyncSender<io::Result<Vec<u8>>>) {
    let mut buffer = vec![0; CHUNK];
    loop {
        let chunk = match source.read(&mut buffer) {
            Ok(0) => return,
            Ok(n) => Ok(buffer.get(..n).unwrap_or_default().to_vec()),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => Err(error),
        };
        let failed = chunk.is_err();
        if chunks.send(chunk).is_err() || failed {
            return;
        }
    }
}

struct LiveSource {
    chunks: Receiver<io::Result<Vec<u8>>>,
    chunk: io::Cursor<Vec<u8>>,
    output: Output,
    interrupt: Interrupt,
}

impl LiveSource {
    /// The next chunk; `None` at the end.
    fn next(&self) -> io::Result<Option<Vec<u8>>> {
        match self.chunks.try_recv() {
            Ok(chunk) => return chunk.map(Some),
            Err(TryRecvError::Disconnected) => return Ok(None),
            // If the output is closed, no more input is needed.
            Err(TryRecvError::Empty) => match self.output.flush() {
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(None),
                flushed => flushed?,
            },
        }
        while !self.interrupt.came() {
            match self.chunks.recv_timeout(LOOK) {
                Ok(chunk) => return chunk.map(Some),
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
        Ok(None)
    }
}

impl Read for LiveSource {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        loop {
            let n = self.chunk.read(buffer)?;
            if n > 0 || buffer.is_empty() {
                return Ok(n);
            }
            match self.next()? {
                Some(chunk) => self.chunk = io::Cursor::new(chunk),
                None => return Ok(0),
            }
        }
    }
}
