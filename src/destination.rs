//! The file that a capture is written to.

use crate::output::Output;
use anyhow::{Context, Result, bail};
use canvass_traces::{Compression, Format, WriteError};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Where a capture goes, in which format.
pub struct Destination {
    path: PathBuf,
    /// The format.
    pub format: Format,
    /// The compression of the whole.
    pub compression: Compression,
    force: bool,
}

impl Destination {
    /// A path with the format that was said, or else the one that its extension tells.
    pub fn new(path: &Path, said: Option<Format>, force: bool) -> Result<Self> {
        let (compression, by_name) = Compression::and_format_of(path);
        let Some(format) = said.or(by_name) else {
            let written: Vec<_> = Format::all().filter(|format| format.is_written()).map(Format::id).collect();
            let written = written.join(", ");
            bail!("{} does not tell the format to write: say --to with one of {written}", path.display());
        };
        if !format.is_written() {
            return Err(WriteError::NotWritten(format).into());
        }
        Ok(Self { path: path.to_owned(), format, compression, force })
    }

    /// Whether it is standard output.
    pub fn is_stdout(&self) -> bool {
        self.path.as_os_str() == "-"
    }

    /// Makes the file, or empties an existing one that may be overwritten. It must be none of the captures read.
    pub fn open(&self, inputs: &[PathBuf], output: &Output) -> Result<Box<dyn Write>> {
        if self.is_stdout() {
            return Ok(Box::new(output.clone()));
        }
        let path = self.path.display();
        if inputs.iter().any(|input| is_same_file(input, &self.path)) {
            bail!("{path} is read and can't be written at the same time");
        }
        let file = match OpenOptions::new().write(true).create_new(true).open(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => self.open_existing(),
            opened => opened.with_context(|| format!("can't write {path}")),
        };
        Ok(Box::new(file?))
    }

    fn open_existing(&self) -> Result<File> {
        let path = self.path.display();
        // A pipe or a device has nothing that could get lost.
        let is_file = fs::metadata(&self.path).map_or(true, |metadata| metadata.is_file());
        if is_file && !self.force {
            bail!("{path} exists: give --force to overwrite it");
        }
        OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(is_file)
            .open(&self.path)
            .with_context(|| format!("can't write {path}"))
    }
}

/// Whether two paths are one file.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    match (fs::canonicalize(a), fs::canonicalize(b)) {
        (Ok(a), Ok(b)) => a == b && a.is_file(),
        _ => false,
    }
}
