//! Files that appear complete or not at all: they are written under another name and renamed when complete. Until
//! then, and after an error, a file of the final name keeps its content.

use anyhow::{Context, Result, bail};
use canvass_reports::escape::Visible;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use tempfile::{Builder, NamedTempFile};

/// A file that is not complete yet.
pub struct WholeFile {
    /// The path as typed.
    path: PathBuf,
    part: Part,
}

enum Part {
    /// A temporary file, and the path that it gets when complete.
    Beside(NamedTempFile, PathBuf),
    /// A pipe or a device, which is written directly: it has no content to keep.
    InPlace(File),
}

/// Writes a whole file at once.
///
/// # Errors
/// If the file can't be written; its former content stays.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let file = WholeFile::create(path)?;
    file.writer()?.write_all(bytes).with_context(|| format!("can't write {}", path.display()))?;
    file.complete()
}

impl WholeFile {
    /// Begins a file.
    ///
    /// # Errors
    /// If the complete file could not get its name later.
    pub fn create(path: &Path) -> Result<Self> {
        let failed = || format!("can't write {}", path.display());
        let part = match fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => bail!("can't write {}: it is a folder", path.display()),
            Ok(metadata) if !metadata.is_file() => {
                Part::InPlace(OpenOptions::new().write(true).open(path).with_context(failed)?)
            }
            Ok(metadata) => {
                // A read-only file must not be replaced by renaming either.
                OpenOptions::new().write(true).open(path).with_context(failed)?;
                let place = fs::canonicalize(path).with_context(failed)?;
                // If the folder takes no new files, the complete file is copied over the old file.
                let part = beside(&place).or_else(|_| Builder::new().tempfile()).with_context(failed)?;
                part.as_file().set_permissions(metadata.permissions()).with_context(failed)?;
                Part::Beside(part, place)
            }
            Err(_) => Part::Beside(beside(path).with_context(failed)?, path.to_owned()),
        };
        Ok(Self { path: path.to_owned(), part })
    }

    /// A writer into the file. All writers share one position.
    ///
    /// # Errors
    /// If the system can't open the file again.
    pub fn writer(&self) -> Result<File> {
        let file = match &self.part {
            Part::Beside(part, _) => part.as_file(),
            Part::InPlace(file) => file,
        };
        file.try_clone().with_context(|| format!("can't write {}", self.path.display()))
    }

    /// A writer for text, which makes control characters visible.
    ///
    /// # Errors
    /// If the system can't open the file again.
    pub fn document(&self) -> Result<BufWriter<Visible<File>>> {
        Ok(BufWriter::new(Visible::new(self.writer()?, false)))
    }

    /// Gives the complete file its final name.
    ///
    /// # Errors
    /// If the system can't rename or copy it.
    pub fn complete(self) -> Result<()> {
        let failed = || format!("can't write {}", self.path.display());
        let Part::Beside(part, place) = self.part else { return Ok(()) };
        part.as_file().sync_data().with_context(failed)?;
        match part.persist(&place) {
            Ok(_) => Ok(()),
            // Renaming fails across file systems and onto a mount point; then the content is copied.
            Err(error) if place.exists() => fs::copy(error.file.path(), &place).map(|_| ()).with_context(failed),
            Err(error) => Err(error.error).with_context(failed),
        }
    }
}

/// A hidden temporary file in the same folder, so that it can be renamed. Its name contains the final name of the file.
fn beside(place: &Path) -> std::io::Result<NamedTempFile> {
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
    let name = place.file_name().unwrap_or_default().to_string_lossy();
    let mut builder = Builder::new();
    let prefix = format!(".{name}.");
    builder.prefix(&prefix).suffix(".part");
    // Permissions as for any new file, limited by the user's mask; the crate's default is private.
    #[cfg(unix)]
    builder.permissions(<fs::Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
    builder.tempfile_in(folder)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names.into_iter().map(|name| name.into_string().unwrap()).collect()
    }

    #[test]
    fn what_was_there_stays_until_all_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("report.json");
        fs::write(&path, "old").unwrap();
        let whole = WholeFile::create(&path).unwrap();
        whole.writer().unwrap().write_all(b"new").unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        whole.complete().unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(names(folder.path()), ["report.json"]);
        // An abandoned file leaves nothing in the folder.
        WholeFile::create(&path).unwrap().writer().unwrap().write_all(b"half").unwrap();
        assert_eq!((fs::read_to_string(&path).unwrap(), names(folder.path()).len()), ("new".to_owned(), 1));
    }

    #[cfg(unix)]
    #[test]
    fn links_and_permissions_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("a"), folder.path().join("b"));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        let whole = WholeFile::create(&link).unwrap();
        whole.writer().unwrap().write_all(b"new").unwrap();
        whole.complete().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&path).unwrap(), "new");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }
}
