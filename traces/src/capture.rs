//! Opening a capture, whatever its format.

use crate::compression;
use crate::{Channels, Damage, Format, ReadOptions, Reader, Record, SkipSet, Source, SourceError, TimeBase};
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
    /// The file is not there or not readable.
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
    /// There is nothing in it.
    #[error("{0} is empty: expected a capture")]
    Empty(String),
    /// No format matches.
    #[error("{name} is of no known format: expected one of {known}", known = known_formats())]
    Unknown {
        /// The file or `-`.
        name: String,
    },
}

fn known_formats() -> String {
    Format::all().map(Format::id).collect::<Vec<_>>().join(", ")
}

impl Capture {
    /// Opens a file, or standard input where the path is `-`.
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

    /// Reads a source under that name. One that is compressed by gzip or zstd is decompressed on the way; offsets
    /// are those in the decompressed content.
    ///
    /// # Errors
    /// [`OpenError`] if nothing can be read, it is empty, or no format matches.
    pub fn from_source(name: &str, source: Source, options: &ReadOptions) -> Result<Self, OpenError> {
        let mut source =
            compression::decompressed(source).map_err(|source| OpenError::Source { name: name.to_owned(), source })?;
        let format = match options.format {
            Some(format) => format,
            None => recognise(name, &mut source)?,
        };
        Ok(Self { name: name.to_owned(), format, reader: format.open(source, options) })
    }

    /// What a reader of another kind gives, such as that of a live bus, under that name, as if it came in that format.
    pub fn from_reader(name: &str, format: Format, reader: Box<dyn Reader>) -> Self {
        Self { name: name.to_owned(), format, reader }
    }

    /// The file's name as it was given, `-` for standard input.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The format that was recognised or said.
    pub fn format(&self) -> Format {
        self.format
    }
}

/// Looks at the head of a source. Only as much is read as is needed, because a pipe may be slow.
fn recognise(name: &str, source: &mut Source) -> Result<Format, OpenError> {
    loop {
        if let Some(format) = Format::sniff(source.window()) {
            return Ok(format);
        }
        let unknown = || OpenError::Unknown { name: name.to_owned() };
        if source.window().len() >= Format::SNIFF {
            return Err(unknown());
        }
        if !source.fill().map_err(|source| OpenError::Source { name: name.to_owned(), source })? {
            return Err(if source.window().is_empty() { OpenError::Empty(name.to_owned()) } else { unknown() });
        }
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

    fn next_kept(&mut self, skip: &mut SkipSet, record: &mut Record) -> Option<Result<(), Damage>> {
        self.reader.next_kept(skip, record)
    }
}

impl std::fmt::Debug for Capture {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Capture({}, {})", self.name, self.format)
    }
}
