//! Opening a capture of any format.

use crate::compression;
use crate::encoding;
use crate::formats::pasted;
use crate::{
    Channels, Damage, Format, Question, ReadOptions, Reader, Record, SkipSet, Source, SourceError, TimeBase, Unread,
};
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

/// An opened capture: its name, its format, and its records.
pub struct Capture {
    name: String,
    format: Format,
    reader: Box<dyn Reader>,
}

/// Why a capture can't be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file does not exist or is not readable.
    #[error("can't open {path}: {source}", path = path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        source: io::Error,
    },
    /// The first bytes can't be read.
    #[error("can't read {name}: {source}")]
    Source {
        /// The file or `-`.
        name: String,
        /// The reason.
        source: SourceError,
    },
    /// The source has no bytes.
    #[error("{0} is empty: expected a capture")]
    Empty(String),
    /// The content matches no format.
    #[error("{name} has no known format: expected one of {known}", known = known_formats())]
    Unknown {
        /// The file or `-`.
        name: String,
    },
    /// The content is of a known kind that is not read.
    #[error("{name} {reason}")]
    Unread {
        /// The file or `-`.
        name: String,
        /// The kind, and what to do.
        reason: Unread,
    },
    /// No line is a frame, or no line fits the columns that are given.
    #[error(
        "no line of {name} is read as a frame: expected lines with an identifier and data; with --columns, one number for each \
         column"
    )]
    Misfit {
        /// The file or `-`.
        name: String,
    },
    /// Pasted lines fit two readings.
    #[error("{name}: {question}")]
    Ambiguous {
        /// The file or `-`.
        name: String,
        /// The two readings.
        question: Question,
    },
}

fn known_formats() -> String {
    Format::all().map(Format::id).collect::<Vec<_>>().join(", ")
}

impl Capture {
    /// Opens a file, or standard input if the path is `-`.
    ///
    /// # Errors
    /// [`OpenError`] if it can't be opened, is empty, or no format matches.
    pub fn open(path: &Path, options: &ReadOptions) -> Result<Self, OpenError> {
        if path.as_os_str() == "-" {
            return Self::from_source("-", Source::new(io::stdin()), options);
        }
        let file = File::open(path).map_err(|source| OpenError::Io { path: path.to_owned(), source })?;
        Self::from_source(&path.display().to_string(), Source::new(file), options)
    }

    /// Reads a source and gives the capture this name. A source compressed by gzip or zstd is decompressed; offsets are
    /// those in the decompressed content. A text in UTF-16 is read as UTF-8.
    ///
    /// # Errors
    /// [`OpenError`] if nothing can be read, it is empty, or no format matches.
    pub fn from_source(name: &str, source: Source, options: &ReadOptions) -> Result<Self, OpenError> {
        let failed = |source| OpenError::Source { name: name.to_owned(), source };
        let mut source = compression::decompressed(source).and_then(encoding::readable).map_err(failed)?;
        let format = match options.format {
            Some(format) => format,
            None => recognise(name, &mut source, options)?,
        };
        if format == Format::Pasted {
            ask(name, &mut source, options)?;
        }
        Ok(Self { name: name.to_owned(), format, reader: format.open(source, options) })
    }

    /// Makes a capture of another kind of reader, such as the reader of a live bus; the capture reports `name` and
    /// `format`.
    pub fn from_reader(name: &str, format: Format, reader: Box<dyn Reader>) -> Self {
        Self { name: name.to_owned(), format, reader }
    }

    /// The file's name as it was given, `-` for standard input.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The recognised format, or the one given in the options.
    pub fn format(&self) -> Format {
        self.format
    }
}

/// Recognises the format from the head of a source. It reads only as much as needed, because a pipe may be slow; only
/// lines in no known format are read up to [`Format::SNIFF`].
fn recognise(name: &str, source: &mut Source, options: &ReadOptions) -> Result<Format, OpenError> {
    loop {
        match Format::sniff_known(source.window()) {
            // Rows of a console are lines with columns too.
            Some(Format::CandumpConsole) if options.columns.is_some() => return Ok(Format::Pasted),
            Some(format) => return Ok(format),
            None => {}
        }
        let failed = |source| OpenError::Source { name: name.to_owned(), source };
        if source.window().len() < Format::SNIFF && source.fill().map_err(failed)? {
            continue;
        }
        let head = source.window();
        return match pasted::unread(head) {
            _ if head.is_empty() => Err(OpenError::Empty(name.to_owned())),
            _ if options.columns.is_some() || pasted::sniff(head) => Ok(Format::Pasted),
            Some(reason) => Err(OpenError::Unread { name: name.to_owned(), reason }),
            None => Err(OpenError::Unknown { name: name.to_owned() }),
        };
    }
}

/// Reads the lines that decide what the columns mean, and fails if the lines fit two readings.
fn ask(name: &str, source: &mut Source, options: &ReadOptions) -> Result<(), OpenError> {
    let failed = |source| OpenError::Source { name: name.to_owned(), source };
    while source.window().len() < Format::SNIFF && source.fill().map_err(failed)? {}
    let name = name.to_owned();
    match pasted::has_meaning(source.window(), options) {
        Err(question) => Err(OpenError::Ambiguous { name, question }),
        Ok(true) => Ok(()),
        Ok(false) if source.window().is_empty() => Err(OpenError::Empty(name)),
        Ok(false) => Err(OpenError::Misfit { name }),
    }
}

impl Iterator for Capture {
    type Item = Result<Record, Damage>;

    fn next(&mut self) -> Option<Self::Item> {
        self.reader.next()
    }
}

impl Reader for Capture {
    fn channels(&self) -> &Channels {
        self.reader.channels()
    }

    fn time_base(&self) -> TimeBase {
        self.reader.time_base()
    }

    fn bit_rate(&self) -> Option<u32> {
        self.reader.bit_rate()
    }

    fn interpretation(&self) -> Option<String> {
        self.reader.interpretation()
    }

    fn next_kept(&mut self, skip: &mut SkipSet, record: &mut Record) -> Option<Result<(), Damage>> {
        self.reader.next_kept(skip, record)
    }
}

impl std::fmt::Debug for Capture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Capture({}, {})", self.name, self.format)
    }
}
