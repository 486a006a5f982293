//! Standard input and output as a connection, with room for messages that are written past it.
//!
//! The connection of `lsp_server` takes messages as trees of values, and keeps standard output to itself. An outline is
//! megabytes: its text goes straight to standard output, and only what begins and ends a session through the connection.

use crate::output::raw;
use anyhow::{Result, anyhow};
use lsp_server::{Connection, Message};
use std::io;
use std::thread::{JoinHandle, spawn};

/// What reads and writes until the session ends.
pub struct Threads {
    reader: JoinHandle<io::Result<()>>,
    writer: JoinHandle<io::Result<()>>,
}

/// Connects with the editor at standard input and output.
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
    /// Waits for both; the connection has to be gone.
    pub fn join(self) -> Result<()> {
        for thread in [self.reader, self.writer] {
            thread.join().map_err(|_| anyhow!("a thread of the session has panicked"))??;
        }
        Ok(())
    }
}
