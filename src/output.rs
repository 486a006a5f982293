//! Standard output and standard error.

use crate::console::takes_sequences;
use canvass_reports::ascii::ascii;
use canvass_reports::document::{Form, Report, Style};
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
                // The user asked for colours, so a console that can't show them gets them too.
                takes_sequences(&raw());
                true
            }
            Self::Never => false,
            Self::Auto => is_terminal() && may_have_colors() && takes_sequences(&raw()),
        }
    }
}

/// How to print a result that people or programs read.
#[derive(Clone, Copy, Default, clap::ValueEnum)]
pub enum TextOrJson {
    /// Lines for people
    #[default]
    Text,
    /// A JSON object
    Json,
}

/// How to print a result with tables.
#[derive(Clone, Copy, Default, clap::ValueEnum)]
pub enum TextJsonOrMarkdown {
    /// For people
    #[default]
    Text,
    /// One JSON object
    Json,
    /// For tickets and wikis
    Markdown,
}

impl TextJsonOrMarkdown {
    /// Prints a report; text gets this style. A closed standard output is no error.
    pub fn print(self, report: &dyn Report, style: Style) -> io::Result<()> {
        let form = match self {
            Self::Text => Form::Text(style),
            Self::Json => Form::Json,
            Self::Markdown => Form::Markdown,
        };
        let mut output = Output::text(style.color);
        unless_closed(report.write(form, &mut output).and_then(|()| Output::flush(&output)))
    }
}

/// Buffered standard output, shared with the reader of standard input: before the reader waits, it flushes the lines
/// decoded so far.
#[derive(Clone)]
pub struct Output(Arc<Mutex<Buffer>>);

struct Buffer {
    bytes: Vec<u8>,
    stream: Stream,
    has_written: bool,
}

enum Stream {
    /// Text, for people or programs.
    Text(Visible<Stdout>),
    /// A capture, in bytes.
    Raw(Stdout),
}

impl Output {
    const FULL: usize = 64 * 1024;

    /// An output for text; `colors` tells whether its colours are kept.
    pub fn text(colors: bool) -> Self {
        Self::new(Stream::Text(document(colors)))
    }

    /// An output for a capture, whose bytes stay unchanged.
    pub fn capture() -> Self {
        Self::new(Stream::Raw(raw()))
    }

    fn new(stream: Stream) -> Self {
        Self(Arc::new(Mutex::new(Buffer { bytes: Vec::new(), stream, has_written: false })))
    }

    /// Lets `append` add to the buffer, and flushes a full buffer.
    pub fn append(&self, append: impl FnOnce(&mut Vec<u8>)) -> io::Result<()> {
        let mut buffer = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        append(&mut buffer.bytes);
        if buffer.bytes.len() >= Self::FULL { buffer.write_out() } else { Ok(()) }
    }

    /// As [`Output::append`], with an `append` that can fail; the bytes added before the error stay.
    pub fn append_with<T>(&self, append: impl FnOnce(&mut Vec<u8>) -> io::Result<T>) -> io::Result<T> {
        let mut buffer = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let appended = append(&mut buffer.bytes)?;
        if buffer.bytes.len() >= Self::FULL {
            buffer.write_out()?;
        }
        Ok(appended)
    }

    /// Whether any of the output has been written out of the buffer.
    pub fn has_written(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).has_written
    }

    /// Flushes the buffer.
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

/// A sink whose flush does not flush standard output: standard output is written when [`Output::flush`] is called or
/// the buffer is full.
impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.append(|buffer| buffer.extend_from_slice(bytes)).map(|()| bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Standard output for text with its control characters made visible; `colors` tells whether the renderer's colours
/// are kept.
pub fn document(colors: bool) -> Visible<Stdout> {
    Visible::new(raw(), colors).in_ascii(is_terminal() && locale_is_ascii())
}

/// Whether the terminal interprets no sequences: then there are no colours, and no line is rewritten.
pub fn is_dumb() -> bool {
    std::env::var_os("TERM").is_some_and(|term| term == "dumb")
}

/// Whether user and terminal accept colours.
fn may_have_colors() -> bool {
    // https://no-color.org: any value but the empty one switches colours off.
    let no_color = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty());
    !no_color && !is_dumb()
}

/// The colours of clap's help and messages. By itself clap would send them to a dumb terminal if `CI` or
/// `CLICOLOR_FORCE` is set.
pub fn colors_of_help() -> clap::ColorChoice {
    if may_have_colors() { clap::ColorChoice::Auto } else { clap::ColorChoice::Never }
}

/// Whether the user's locale is ASCII. Terminals follow the locale; files and pipes are UTF-8 in any locale.
fn locale_is_ascii() -> bool {
    let said =
        ["LC_ALL", "LC_CTYPE", "LANG"].into_iter().filter_map(std::env::var_os).find(|locale| !locale.is_empty());
    said.is_some_and(|locale| locale == "C" || locale == "POSIX")
}

/// The text in the characters that a terminal of the user's locale can show.
fn shown(text: &str, is_terminal: bool) -> Cow<'_, str> {
    if is_terminal && locale_is_ascii() { ascii(text) } else { Cow::Borrowed(text) }
}

/// Standard output for bytes that programs read: captures, scripts for shells. Text goes through [`document`].
#[expect(clippy::disallowed_methods, reason = "all other modules write through this one")]
pub fn raw() -> Stdout {
    io::stdout()
}

/// Whether standard output is a terminal.
pub fn is_terminal() -> bool {
    raw().is_terminal()
}

#[expect(clippy::disallowed_methods, reason = "all other modules write through this one")]
fn stderr() -> Stderr {
    io::stderr()
}

/// Whether standard error is a terminal on which a line can be rewritten.
pub fn is_seen() -> bool {
    stderr().is_terminal() && !is_dumb() && takes_sequences(&stderr())
}

/// Whether the last line of standard error shows a progress.
static PROGRESS_IS_SHOWN: AtomicBool = AtomicBool::new(false);

/// Rewrites the progress line of standard error, which must be a terminal; an empty text clears it.
pub fn show_progress(line: &Printable) {
    let mut stderr = stderr().lock();
    PROGRESS_IS_SHOWN.store(!line.as_str().is_empty(), Ordering::Relaxed);
    let line = shown(line.as_str(), true);
    let _ = write!(stderr, "\r\x1b[K{line}").and_then(|()| stderr.flush());
}

/// The width of the terminal, if standard output is one.
pub fn terminal_width() -> Option<u16> {
    terminal_size::terminal_size_of(raw()).map(|(width, _)| width.0)
}

/// Prints a text. A closed standard output is no error: result and exit status of a command do not depend on its
/// reader.
pub fn print(text: &Printable) -> io::Result<()> {
    let mut stdout = raw().lock();
    let text = shown(text.as_str(), is_terminal());
    unless_closed(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()))
}

/// Writes a file to standard output as it is. A closed standard output is no error.
pub fn write_bytes(bytes: &[u8]) -> io::Result<()> {
    let mut output = raw();
    unless_closed(output.write_all(bytes).and_then(|()| output.flush()))
}

/// Ignores a closed standard output: the result of the command stays true, and its other outputs are still needed.
pub fn unless_closed(written: io::Result<()>) -> io::Result<()> {
    match written {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        written => written,
    }
}

/// Prints a line to standard error; errors are ignored, as they can't be reported anywhere.
///
/// Control characters and line ends are made visible, so that no name of a file or device can imitate a message of
/// canvass.
pub fn diagnostic(line: &str) {
    // The message replaces a progress line.
    let clear = if PROGRESS_IS_SHOWN.swap(false, Ordering::Relaxed) { "\r\x1b[K" } else { "" };
    let (line, is_terminal) = (Printable::line(line), stderr().is_terminal());
    let _ = writeln!(stderr().lock(), "{clear}{}", shown(line.as_str(), is_terminal));
}

/// As [`diagnostic`], for a text of several lines.
pub fn diagnostics(text: &str) {
    text.lines().for_each(diagnostic);
}
