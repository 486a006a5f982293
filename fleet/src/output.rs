//! Standard output and standard error: text from captures can't control the terminal.

use canvass_fleet::render::Format;
use canvass_reports::escape::Visible;
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal as _, Write};
use std::path::Path;
use tempfile::NamedTempFile;

/// Whether standard output is a terminal.
#[expect(clippy::disallowed_methods, reason = "this module is the only place that has it")]
pub fn is_terminal() -> bool {
    io::stdout().is_terminal()
}

/// Refuses to write a binary format to a terminal.
///
/// # Errors
/// If the output would go to a terminal.
pub fn refuse_terminal(format: Format, output: Option<&Path>) -> anyhow::Result<()> {
    let is_refused = format.is_binary() && output.is_none() && is_terminal();
    anyhow::ensure!(!is_refused, "the format is not for a terminal: give --output FILE, or redirect the output");
    Ok(())
}

/// Standard output for bytes that stay unchanged: the renderers of answers escape control characters themselves.
#[expect(clippy::disallowed_methods, reason = "this module is the only place that has it")]
pub fn raw() -> Box<dyn Write + Send> {
    Box::new(BufWriter::new(io::stdout()))
}

/// Prints text that people read.
///
/// # Errors
/// If standard output can't be written.
#[expect(clippy::disallowed_methods, reason = "this module is the only place that has it")]
pub fn print(text: &str) -> io::Result<()> {
    let mut out = Visible::new(io::stdout(), false);
    out.write_all(text.as_bytes())?;
    out.write_all(b"\n")?;
    out.flush()
}

/// Prints a line to standard error.
#[expect(clippy::disallowed_methods, reason = "this module is the only place that has it")]
pub fn diagnostic(text: &str) {
    let mut out = Visible::new(io::stderr(), false);
    // An error is ignored, as it can't be reported anywhere.
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
}

/// Shows a progress text, on a terminal only.
#[expect(clippy::disallowed_methods, reason = "this module is the only place that has it")]
pub fn progress(text: &str) {
    if io::stderr().is_terminal() {
        let _ = write!(io::stderr(), "\r\x1b[K{text}");
    }
}

/// A file that appears when it is complete, or not at all.
pub struct WholeFile {
    file: NamedTempFile,
    path: std::path::PathBuf,
}

impl WholeFile {
    /// Begins a temporary file in the folder of `path`.
    ///
    /// # Errors
    /// If the folder can't be written.
    pub fn create(path: &Path) -> io::Result<Self> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        // Permissions as for any new file, limited by the user's mask.
        #[cfg(unix)]
        builder.permissions(<std::fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
        let file = builder
            .tempfile_in(folder)
            .map_err(|error| io::Error::new(error.kind(), format!("can't write {}: {error}", path.display())))?;
        Ok(Self { file, path: path.to_owned() })
    }

    /// A writer into the file.
    ///
    /// # Errors
    /// If the file can't be opened again.
    pub fn writer(&self) -> io::Result<Box<dyn Write + Send>> {
        Ok(Box::new(BufWriter::new(File::options().write(true).open(self.file.path())?)))
    }

    /// Gives the complete file its final name.
    ///
    /// # Errors
    /// If the file can't be renamed.
    pub fn complete(self) -> io::Result<()> {
        self.file.persist(&self.path).map(|_| ()).map_err(|error| error.error)
    }
}
