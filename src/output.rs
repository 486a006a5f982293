//! Standard output and standard error.

use crate::console::takes_sequences;
use canvass_reports::ascii::ascii;
use canvass_reports::escape::{Printable, Visible};
use std::borrow::Cow;
use std::io::{self, IsTerminal, Stderr, Stdout, Write};
use std::sync::atomic::{AtomicBool, Ordering};
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
            Self::Always => {
                // A console that can't show them gets them all the same: that was asked for.
                takes_sequences(&raw());
                true
            }
            Self::Never => false,
            Self::Auto => is_terminal() && may_have_colors() && takes_sequences(&raw()),
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
#[derive(Clone)]
pub struct Output(Arc<Mutex<Buffer>>);

struct Buffer {
    bytes: Vec<u8>,
    stream: Stream,
    has_written: bool,
}

enum Stream {
    /// What people read, or may.
    Text(Visible<Stdout>),
    /// A capture.
    Raw(Stdout),
}

impl Output {
    const FULL: usize = 64 * 1024;

    /// Of text, with or without the colours that its renderer sets.
    pub fn text(colors: bool) -> Self {
        Self::new(Stream::Text(document(colors)))
    }

    /// Of a capture, whose bytes stay as they are.
    pub fn capture() -> Self {
        Self::new(Stream::Raw(raw()))
    }

    fn new(stream: Stream) -> Self {
        Self(Arc::new(Mutex::new(Buffer { bytes: Vec::new(), stream, has_written: false })))
    }

    /// Lets `append` add to the buffer, and writes it out when it is full.
    pub fn append(&self, append: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        let mut buffer = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        append(&mut buffer.bytes);
        if buffer.bytes.len() >= Self::FULL { buffer.write_out() } else { Ok(()) }
    }

    /// The same where adding can fail; what was added before that stays.
    pub fn append_with<T>(&self, append: impl FnOnce(&mut Vec<u8>) -> io::Result<T>) -> io::Result<T> {
        let mut buffer = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let appended = append(&mut buffer.bytes)?;
        if buffer.bytes.len() >= Self::FULL {
            buffer.write_out()?;
        }
        Ok(appended)
    }

    /// Whether anything of it is where others see it.
    pub fn has_written(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).has_written
    }

    /// Writes out what is in the buffer.
    pub fn flush(&self) -> io::Result<()> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).write_out()
    }
}

impl Buffer {
    fn write_out(&mut self) -> io::Result<()> {
        let stream: &mut dyn Write = match &mut self.stream {
            Stream::Text(stream) => stream,
            Stream::Raw(stream) => stream,
        };
        self.has_written |= !self.bytes.is_empty();
        let written = stream.write_all(&self.bytes).and_then(|()| stream.flush());
        self.bytes.clear();
        written
    }
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

/// Standard output for a document of which nothing may act, with or without the colours that its renderer sets.
pub fn document(colors: bool) -> Visible<Stdout> {
    Visible::new(raw(), colors).in_ascii(is_terminal() && locale_is_ascii())
}

/// Whether the terminal knows no sequences: nothing has colours then, and no line takes the place of another.
pub fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|term| term == "dumb")
}

/// Whether the user and the terminal take colours.
fn may_have_colors() -> bool {
    // https://no-color.org: any value but the empty one switches colours off.
    let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    !no_color && !is_dumb()
}

/// The colours of clap's help and messages. Left alone it sends them to a terminal that knows none wherever `CI` or
/// `CLICOLOR_FORCE` is set.
pub fn colors_of_help() -> clap::ColorChoice {
    if may_have_colors() { clap::ColorChoice::Auto } else { clap::ColorChoice::Never }
}

/// Whether the user's locale is one of ASCII. Terminals keep to it; files and pipes are UTF-8 in any locale.
fn locale_is_ascii() -> bool {
    let said =
        ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().filter_map(std::env::var_os).find(|locale| !locale.is_empty());
    said.is_some_and(|locale| locale == "C" || locale == "POSIX")
}

/// The text as a terminal of the user's locale shows it.
fn shown(text: &str, is_terminal: bool) -> Cow<'_, str> {
    if is_terminal && locale_is_ascii() { ascii(text) } else { Cow::Borrowed(text) }
}

/// Standard output as it is, for what programs read: captures, scripts for shells. Text goes through [`document`].
#[expect(clippy::disallowed_methods, reason = "this module is the only place that has it")]
pub fn raw() -> Stdout {
    io::stdout()
}

/// Whether standard output is a terminal.
pub fn is_terminal() -> bool {
    raw().is_terminal()
}

#[expect(clippy::disallowed_methods, reason = "this module is the only place that has it")]
fn stderr() -> Stderr {
    io::stderr()
}

/// Whether somebody sees standard error as it is written, on a terminal on which a line can take the place of another.
pub fn is_seen() -> bool {
    stderr().is_terminal() && !is_dumb() && takes_sequences(&stderr())
}

/// Whether the last line of standard error is a progress.
static PROGRESS_IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// Writes a line of standard error, which must be a terminal, in place of the one before it; an empty one clears it. Who
/// does not see it misses nothing.
pub fn show_progress(line: &Printable) {
    let mut stderr = stderr().lock();
    PROGRESS_IS_SHOWN.store(!line.as_str().is_empty(), Ordering::Relaxed);
    let line = shown(line.as_str(), true);
    let _ = write!(stderr, "\r\x1b[K{line}").and_then(|()| stderr.flush());
}

/// The columns of standard output, if it is a terminal.
pub fn terminal_width() -> Option<u16> {
    terminal_size::terminal_size_of(raw()).map(|(width, _)| width.0)
}

/// Writes a text to standard output. That nobody reads it any more is no error: what a command has found out, and the status
/// that it ends with, do not depend on that.
pub fn print(text: &Printable) -> io::Result<()> {
    let mut stdout = raw().lock();
    let text = shown(text.as_str(), is_terminal());
    unless_closed(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
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
    // It takes the place of a progress that is shown.
    let clear = if PROGRESS_IS_SHOWN.swap(false, Ordering::Relaxed) { "\r\x1b[K" } else { "" };
    let (line, is_terminal) = (Printable::line(line), stderr().is_terminal());
    let _ = writeln!(stderr().lock(), "{clear}{}", shown(line.as_str(), is_terminal));
}

/// The same for a text of several lines.
pub fn diagnostics(text: &str) {
    text.lines().for_each(diagnostic);
}
