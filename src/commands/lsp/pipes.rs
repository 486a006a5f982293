//! A connection on standard input and output that also takes ready-made JSON text.
//!
//! The connection of `lsp_server` takes messages as trees of values and owns standard output. An outline has
//! megabytes; so its text goes to standard output directly, and the connection serves only the start and the end of a
//! session.

use crate::output::raw;
use anyhow::{Result, anyhow};
use lsp_server::{Connection, Message};
use std::io;
use std::thread::{JoinHandle, spawn};

/// The reading and the writing thread of a session.
pub struct Threads {
    reader: JoinHandle<io::Result<()>>,
    writer: JoinHandle<io::Result<()>>,
}

/// Connects to the editor at standard input and output.
pub fn connect() -> (Connection, Threads) {
    let (ours, theirs) = Connection::memory();
    let Connection { sender, receiver } = theirs;
    let reader = spawn(move || {
        let mut input = io::stdin().lock();
        while let Some(message) = Message::read(&mut input)? {
            let is_last = matches!(&message, Message::Notification(said) if said.method == "exit");
            if sender.send(message).is_err() || is_last {
                break;
            }
        }
        Ok(())
    });
    let writer = spawn(move || receiver.iter().try_for_each(|message| message.write(&mut raw().lock())));
    (ours, Threads { reader, writer })
}

impl Threads {
    /// Waits for both threads; the connection must have been dropped.
    pub fn join(self) -> Result<()> {
        for thread in [self.reader, self.writer] {
            thread.join().map_err(|_| anyhow!("a thread of the session panicked"))??;
        }
        Ok(())
    }
}
