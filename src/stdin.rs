//! Standard input as a live source: while it has nothing, what was made of it so far goes out, and Ctrl-C ends it.

use crate::interrupt::Interrupt;
use crate::output::Output;
use std::io::{self, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread;
use std::time::Duration;

/// How often Ctrl-C is looked for while there is nothing to read.
const LOOK: Duration = Duration::from_millis(50);
const CHUNK: usize = 64 * 1024;

/// Standard input, which flushes `output` whenever it is about to wait, and ends when interrupted.
///
/// It is read in a thread of its own, because a read can't be interrupted.
pub fn live(output: Output, interrupt: Interrupt) -> impl Read + Send + 'static {
    let (sender, chunks) = sync_channel(4);
    thread::spawn(move || read_all(&sender));
    LiveStdin { chunks, chunk: io::Cursor::default(), output, interrupt }
}

fn read_all(chunks: &SyncSender<io::Result<Vec<u8>>>) {
    let mut stdin = io::stdin();
    let mut buffer = vec![0; CHUNK];
    loop {
        let chunk = match stdin.read(&mut buffer) {
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

struct LiveStdin {
    chunks: Receiver<io::Result<Vec<u8>>>,
    chunk: io::Cursor<Vec<u8>>,
    output: Output,
    interrupt: Interrupt,
}

impl LiveStdin {
    /// The next chunk; `None` at the end.
    fn next(&self) -> io::Result<Option<Vec<u8>>> {
        match self.chunks.try_recv() {
            Ok(chunk) => return chunk.map(Some),
            Err(TryRecvError::Disconnected) => return Ok(None),
            Err(TryRecvError::Empty) => self.output.flush()?,
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

impl Read for LiveStdin {
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
