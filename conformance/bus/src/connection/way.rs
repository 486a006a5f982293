//! The writing side of the connection to an adapter, shared by the sender and the reading thread.

use std::io::{self, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The connection to an adapter.
#[derive(Default)]
pub struct Way(Mutex<State>);

type Writer = Box<dyn Write + Send>;

#[derive(Default)]
enum State {
    /// No connection.
    #[default]
    Closed,
    /// The adapter's channel is being opened: the adapter takes commands, but no frames yet.
    Opening(Writer),
    /// The adapter takes frames.
    Open(Writer),
    /// Writing failed. The reading thread may still wait for bytes and not know of the failure.
    Failed(io::Error),
}

impl State {
    /// Writes a line. After an error the connection takes no more lines, because the other end may have received a part
    /// of the failed line.
    fn write(&mut self, line: &[u8]) -> io::Result<()> {
        let writer = match self {
            Self::Opening(writer) | Self::Open(writer) => writer,
            Self::Closed | Self::Failed(_) => return Err(io::ErrorKind::NotConnected.into()),
        };
        writer.write_all(line).and_then(|()| writer.flush()).inspect_err(|error| {
            *self = Self::Failed(error.kind().into());
        })
    }
}

impl Way {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Stores a new connection, whose channel is still closed.
    pub fn connect(&self, writer: Writer) {
        *self.state() = State::Opening(writer);
    }

    /// Marks the channel as open.
    pub fn open(&self) {
        let mut state = self.state();
        *state = match std::mem::take(&mut *state) {
            State::Opening(writer) => State::Open(writer),
            other => other,
        };
    }

    /// Removes the connection.
    pub fn close(&self) {
        *self.state() = State::Closed;
    }

    /// The error of a failed write, returned once.
    pub(crate) fn take_failure(&self) -> Option<io::Error> {
        let mut state = self.state();
        match std::mem::take(&mut *state) {
            State::Failed(error) => Some(error),
            other => {
                *state = other;
                None
            }
        }
    }

    /// Writes a frame.
    pub fn send(&self, line: &[u8]) -> io::Result<()> {
        let mut state = self.state();
        match &*state {
            State::Open(_) => state.write(line),
            _ => Err(io::ErrorKind::NotConnected.into()),
        }
    }

    /// Writes a command, or the answer to a command.
    pub fn tell(&self, line: &[u8]) -> io::Result<()> {
        self.state().write(line)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A connection that takes this number of bytes, and then no more.
    struct Full(usize);

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let taken = bytes.len().min(self.0);
            self.0 -= taken;
            if taken == 0 { Err(io::ErrorKind::TimedOut.into()) } else { Ok(taken) }
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn frames_wait_for_the_channel_and_a_failure_is_told_once() {
        let way = Way::default();
        assert!(way.tell(b"O\r").is_err() && way.send(b"t0010\r").is_err());
        way.connect(Box::new(Full(10)));
        assert!(way.send(b"t0010\r").is_err(), "the adapter would refuse it");
        way.tell(b"O\r").unwrap();
        way.open();
        way.send(b"t0010\r").unwrap();
        assert!(way.send(b"t0020\r").is_err(), "a part of it was taken");
        assert!(way.send(b"\r").is_err());
        assert_eq!(way.take_failure().map(|error| error.kind()), Some(io::ErrorKind::TimedOut));
        assert!(way.take_failure().is_none());
    }
}
