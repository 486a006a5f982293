//! Standard output and standard error.

use canvass_reports::escape;
use std::io::{self, IsTerminal, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// Whether to use colours.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, clap::ValueEnum)]
pub enum Color {
    /// On a terminal, unless `NO_COLOR` is set.
    #[default]
    Auto,
    /// Always.
    Always,
    /// Never.
    Never,
}

impl Color {
    /// Whether standard output gets colours.
    pub fn on_stdout(self) -> bool {
        match self {
            Self::Always => true,
            Self::Never => false,
            // https://no-color.org: any value but the empty one switches colours off.
            Self::Auto => {
                let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
                !no_color && io::stdout().is_terminal()
            }
        }
    }
}

/// How to print a result that is either read or processed.
#[derive(Clone, Copy, Default, clap::ValueEnum)]
pub enum TextOrJson {
    /// Lines for people
    #[default]
    Text,
    /// A JSON object
    Json,
}

/// Buffered standard output that can be shared with the reader of standard input: before that waits for more, what
/// was decoded so far goes out.
#[derive(Clone, Default)]
pub struct Output(Arc<Mutex<Vec<u8>>>);

impl Output {
    const FULL: usize = 64 * 1024;

    /// Lets `append` add to the buffer, and writes it out when it is full.
    pub fn append(&self, append: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        let mut buffer = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        append(&mut buffer);
        if buffer.len() >= Self::FULL { write_out(&mut buffer) } else { Ok(()) }
    }

    /// The same where adding can fail; what was added before that stays.
    pub fn append_with<T>(&self, append: impl FnOnce(&mut Vec<u8>) -> io::Result<T>) -> io::Result<T> {
        let mut buffer = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let appended = append(&mut buffer)?;
        if buffer.len() >= Self::FULL {
            write_out(&mut buffer)?;
        }
        Ok(appended)
    }

    /// Writes out what is in the buffer.
    pub fn flush(&self) -> io::Result<()> {
        write_out(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

fn write_out(buffer: &mut Vec<u8>) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    let written = stdout.write_all(buffer).and_then(|()| stdout.flush());
    buffer.clear();
    written
}

/// As a sink: nothing reaches standard output before it is flushed or full, whatever flushes the sink.
impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.append(|buffer| buffer.extend_from_slice(bytes)).map(|()| bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The columns of standard output, if it is a terminal.
pub fn terminal_width() -> Option<usize> {
    terminal_size::terminal_size_of(io::stdout()).map(|(width, _)| usize::from(width.0))
}

/// Writes a text to standard output.
pub fn print(text: &str) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush())
}

/// Takes it for written if nobody reads standard output any more: what a command has found out stays true, and its other
/// outputs are still wanted.
pub fn unless_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Writes a line to standard error. If nobody reads that either, there is nobody left to tell.
///
/// Whatever names and texts it is made of: characters that act are made visible, line ends too, so that no file's name and
/// no device's can look like a message of its own.
pub fn diagnostic(line: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", escape::printable(line));
}

/// The same for a text of several lines.
pub fn diagnostics(text: &str) {
    text.lines().for_each(diagnostic);
}
