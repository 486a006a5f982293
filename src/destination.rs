//! The output file of a capture.

use crate::output::Output;
use crate::whole_file::WholeFile;
use anyhow::{Context, Result, bail};
use canvass_traces::{Compression, Format, WriteError, Writer};
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};

/// Path and format of an output.
pub struct Destination {
    path: PathBuf,
    pub format: Format,
    /// The compression of the whole file.
    pub compression: Compression,
    force: bool,
}

impl Destination {
    /// The format is `said` if the user gave one, otherwise the format of the path's extension.
    pub fn new(path: &Path, said: Option<Format>, force: bool) -> Result<Self> {
        let (compression, by_name) = Compression::and_format_of(path);
        let Some(format) = said.or(by_name) else {
            let written: Vec<_> = Format::all().filter(|format| format.is_written()).map(Format::id).collect();
            let written = written.join(", ");
            bail!("{} does not show which format to write: use --to with one of {written}", path.display());
        };
        if !format.is_written() {
            return Err(WriteError::NotWritten(format).into());
        }
        if format.rewrites_beginning() && (path.as_os_str() == "-" || compression != Compression::None) {
            bail!(
                "{} states its length at its beginning, which a pipe or a compressed file does not allow: name a file \
                 that is not compressed",
                format.summary()
            );
        }
        Ok(Self { path: path.to_owned(), format, compression, force })
    }

    /// Whether the output is standard output.
    pub fn is_stdout(&self) -> bool {
        self.path.as_os_str() == "-"
    }

    /// Opens the output: a writer, and the file that is completed at the end (`None` for standard output).
    pub fn open(&self, output: &Output) -> Result<(Box<dyn Write>, Option<WholeFile>)> {
        if self.is_stdout() {
            return Ok((Box::new(output.clone()), None));
        }
        if !self.force {
            refuse_existing(&self.path)?;
        }
        let whole = WholeFile::create(&self.path)?;
        Ok((Box::new(whole.writer()?), Some(whole)))
    }

    /// Opens an output for frames of a live bus: the file gets its final name at the start, so that it is found there
    /// even if this program is killed.
    pub fn open_growing(&self, output: &Output) -> Result<Box<dyn Write>> {
        if self.is_stdout() {
            return Ok(Box::new(output.clone()));
        }
        let path = self.path.display();
        let file = match OpenOptions::new().write(true).create_new(true).open(&self.path) {
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => self.open_existing(),
            opened => opened.with_context(|| format!("can't write {path}")),
        };
        Ok(Box::new(file?))
    }

    fn open_existing(&self) -> Result<File> {
        if !self.force {
            refuse_existing(&self.path)?;
        }
        let is_file = is_file(&self.path);
        OpenOptions::new()
            .write(true)
            .create(true)
            .truncate(is_file)
            .open(&self.path)
            .with_context(|| format!("can't write {}", self.path.display()))
    }
}

/// Overwrites the beginning of a finished file, if the format states there what is known only at the end.
pub fn complete_beginning(mut file: File, writer: &dyn Writer) -> Result<()> {
    let Some(beginning) = writer.beginning() else { return Ok(()) };
    let written = file.rewind().and_then(|()| file.write_all(beginning)).and_then(|()| file.flush());
    written.context("can't complete the beginning of the capture")
}

/// Opens a finished file, and overwrites its beginning as [`complete_beginning`] does.
pub fn complete_beginning_of(path: &Path, writer: &dyn Writer) -> Result<()> {
    if writer.beginning().is_none() {
        return Ok(());
    }
    let file = OpenOptions::new().write(true).open(path).with_context(|| format!("can't write {}", path.display()))?;
    complete_beginning(file, writer)
}

/// Refuses to overwrite a file without `--force`. A pipe or a device has no content to lose.
pub fn refuse_existing(path: &Path) -> Result<()> {
    if fs::symlink_metadata(path).is_ok() && is_file(path) {
        bail!("{} exists: give --force to overwrite it", path.display());
    }
    Ok(())
}

/// A path that can't be examined counts as a file.
fn is_file(path: &Path) -> bool {
    fs::metadata(path).map_or(true, |metadata| metadata.is_file())
}
