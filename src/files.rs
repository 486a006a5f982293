//! The files of one command: no output may be an input, and no two outputs may be the same file.
//!
//! The system's identity of a file decides whether two files are the same: another spelling of the path or a link hides
//! nothing. A command checks all files before it opens the first for writing.

use crate::devices::named;
use anyhow::{Result, bail};
use canvass_device::MotionSpec;
use canvass_device::address::{BusAddress, DeviceName, SimulatedDevice};
use canvass_device::models::Model;
use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// The files named so far.
pub struct Files(Vec<Known>);

struct Known {
    /// The file's name as typed.
    name: String,
    identity: Identity,
    use_: Use,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Use {
    Read,
    Written,
}

/// An identity that distinguishes a file from all others.
#[derive(PartialEq, Eq)]
enum Identity {
    /// Device and inode of a file that exists.
    #[cfg(unix)]
    Inode(u64, u64),
    /// The path of a file that may not exist yet.
    Path(PathBuf),
}

impl Files {
    /// Begins with standard input and output, if they are files.
    pub fn new() -> Self {
        let standard = [
            (standard_file(&io::stdin()), "standard input", Use::Read),
            (standard_file(&crate::output::raw()), "standard output", Use::Written),
        ];
        let known = |(identity, name, use_): (Option<Identity>, &str, Use)| {
            Some(Known { name: name.to_owned(), identity: identity?, use_ })
        };
        Self(standard.into_iter().filter_map(known).collect())
    }

    /// Adds inputs. Missing files are reported when they are opened.
    pub fn reads<'a, P: AsRef<Path> + ?Sized + 'a>(mut self, paths: impl IntoIterator<Item = &'a P>) -> Self {
        let known = |path: &P| {
            let path = path.as_ref();
            let identity = Identity::of_existing(path)?;
            Some(Known { name: path.display().to_string(), identity, use_: Use::Read })
        };
        self.0.extend(paths.into_iter().filter_map(known));
        self
    }

    /// Adds the files among values of `--device`: `MODEL`, `FILE` or `NODE=FILE`.
    pub fn describes<'a>(self, devices: impl IntoIterator<Item = &'a str>) -> Self {
        self.reads(devices.into_iter().map(named).filter(|device| Model::by_id(device).is_none()))
    }

    /// Adds the files that a bus address names.
    pub fn bus(self, address: &str) -> Self {
        let Ok(BusAddress::Simulated(devices)) = address.parse() else { return self };
        let of_device = |device: &SimulatedDevice| {
            let description = match &device.device {
                DeviceName::File(path) => Some(path.clone()),
                DeviceName::Model(_) => None,
            };
            let motion = match &device.motion {
                Some(MotionSpec::File(path)) => Some(path.clone()),
                _ => None,
            };
            [description, motion]
        };
        let files: Vec<String> = devices.iter().flat_map(of_device).flatten().collect();
        self.reads(&files)
    }

    /// Adds outputs.
    ///
    /// # Errors
    /// If one of the outputs is an input or another output.
    pub fn writes<'a, P: AsRef<Path> + ?Sized + 'a>(mut self, paths: impl IntoIterator<Item = &'a P>) -> Result<Self> {
        for path in paths.into_iter().map(AsRef::as_ref).filter(|path: &&Path| path.as_os_str() != "-") {
            let Some(identity) = Identity::of_output(path) else { continue };
            let name = path.display().to_string();
            match self.0.iter().find(|known| known.identity == identity) {
                Some(known) if known.use_ == Use::Read => {
                    let also = if known.name == name { String::new() } else { format!(" (as {})", known.name) };
                    bail!("{name} is read{also} and can't be written at the same time: name another file");
                }
                Some(known) => {
                    let also = if known.name == name { "twice".to_owned() } else { format!("as {} too", known.name) };
                    bail!("{name} is to be written {also}: give each output a file of its own");
                }
                None => self.0.push(Known { name, identity, use_: Use::Written }),
            }
        }
        Ok(self)
    }
}

impl Identity {
    /// The identity of an existing file; `None` if no file exists, or if it has no content to lose (a pipe, a device).
    fn of_existing(path: &Path) -> Option<Self> {
        let metadata = fs::metadata(path).ok()?;
        Self::of(&metadata, || fs::canonicalize(path).ok())
    }

    fn of_output(path: &Path) -> Option<Self> {
        if fs::metadata(path).is_ok() {
            return Self::of_existing(path);
        }
        // The file does not exist yet, but its folder does.
        let name = path.file_name()?;
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
        let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
        // Names that differ only in case are one file on Windows.
        let name = if cfg!(windows) { name.to_ascii_lowercase() } else { name.to_owned() };
        Some(Self::Path(folder.join(name)))
    }

    #[cfg(unix)]
    fn of(metadata: &Metadata, _: impl FnOnce() -> Option<PathBuf>) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        metadata.is_file().then(|| Self::Inode(metadata.dev(), metadata.ino()))
    }

    #[cfg(not(unix))]
    fn of(metadata: &Metadata, path: impl FnOnce() -> Option<PathBuf>) -> Option<Self> {
        metadata.is_file().then(path).flatten().map(Self::Path)
    }
}

#[cfg(unix)]
fn standard_file(stream: &impl std::os::fd::AsFd) -> Option<Identity> {
    let file = fs::File::from(stream.as_fd().try_clone_to_owned().ok()?);
    Identity::of(&file.metadata().ok()?, || None)
}

/// This system offers no identity of standard files.
#[cfg(not(unix))]
fn standard_file<S>(_: &S) -> Option<Identity> {
    None
}
